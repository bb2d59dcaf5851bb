import pytest

from sunset_ros.task import Future


def test_a_result_comes_once_and_is_told_to_those_who_wait() -> None:
    future: Future[int] = Future()
    seen: list[Future[int]] = []
    future.add_done_callback(seen.append)
    before = (future.done(), future.result())
    future.set_result(1)
    future.set_result(2)
    future.add_done_callback(seen.append)
    assert before == (False, None)
    assert (future.done(), future.result(), future.cancelled()) == (True, 1, False)
    assert seen == [future, future]


def test_an_exception_is_raised_where_the_result_is_asked_for() -> None:
    future: Future[int] = Future()
    future.set_exception(ValueError("bad luck"))
    future.set_result(1)
    assert isinstance(future.exception(), ValueError)
    with pytest.raises(ValueError, match="bad luck"):
        future.result()


def test_a_cancelled_future_takes_no_result() -> None:
    future: Future[int] = Future()
    future.cancel()
    future.set_result(1)
    future.set_exception(ValueError())
    assert (future.done(), future.cancelled(), future.result()) == (True, True, None)


def test_a_done_future_cannot_be_cancelled() -> None:
    future: Future[int] = Future()
    future.set_result(1)
    future.cancel()
    assert not future.cancelled()


def test_it_shows_its_state() -> None:
    future: Future[int] = Future()
    states = [repr(future)]
    future.set_result(1)
    states.append(repr(future))
    assert states == ["<Future pending>", "<Future done>"]
