import pytest

from sunset_ros.errors import MiddlewareError
from sunset_ros.rmw.dds import CycloneDDS, domains
from sunset_ros.rmw.dds.domains import free_domain_id, sole_system


def test_a_domain_is_given_to_one_at_a_time() -> None:
    with free_domain_id() as first, free_domain_id() as second:
        assert first != second
        assert {first, second} <= set(range(1, 102))


def test_a_domain_with_a_process_in_it_is_not_free(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(domains, "_DOMAINS", range(224, 225))  # one that no other test gets
    with CycloneDDS(domain_id=224, environment={}):  # noqa: SIM117  one after the other
        with (
            pytest.raises(MiddlewareError, match=r"^All domain ids from 224 to 224 are in use\.$"),
            free_domain_id(),
        ):
            pass
    with free_domain_id() as domain_id:
        assert domain_id == 224
    with free_domain_id() as domain_id:
        assert domain_id == 224


def test_every_domain_has_a_port_that_tells_of_its_system_and_is_no_participants() -> None:
    with CycloneDDS(domain_id=232, environment={}), sole_system(232):
        assert CycloneDDS(domain_id=232, environment={}).nodes() == []


def test_a_domain_has_one_system_whatever_user_or_folder_it_is_of() -> None:
    with free_domain_id() as domain_id, sole_system(domain_id):
        with (
            pytest.raises(
                MiddlewareError, match=rf"^Another system runs in domain {domain_id} on this computer"
            ),
            sole_system(domain_id),
        ):
            pass
        with free_domain_id() as other, sole_system(other):
            assert other != domain_id
