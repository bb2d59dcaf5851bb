from sunset_ros.rmw.sim._network import Priority, Scheduler


def test_events_happen_by_time_then_priority_then_order_of_addition() -> None:
    scheduler = Scheduler()
    seen: list[object] = []
    for time, priority, name in (
        (20, Priority.COMPLETION, "later"),
        (10, Priority.CALL, "call"),
        (10, Priority.DELIVERY, "first delivery"),
        (10, Priority.DELIVERY, "second delivery"),
        (10, Priority.COMPLETION, "completion"),
        (10, Priority.TIMER, "timer"),
    ):
        scheduler.add(time, priority, seen.append, name)
    scheduler.run_until(20)
    assert seen == ["completion", "first delivery", "second delivery", "timer", "call", "later"]


def test_run_until_includes_its_moment_and_sets_the_clock() -> None:
    scheduler = Scheduler()
    seen: list[object] = []
    scheduler.add(100, Priority.CALL, seen.append, "due")
    scheduler.add(101, Priority.CALL, seen.append, "not due")
    scheduler.run_until(100)
    assert (seen, scheduler.now) == (["due"], 100)
    scheduler.run_until(50)
    assert scheduler.now == 100


def test_the_clock_reads_the_time_of_the_event() -> None:
    scheduler = Scheduler()
    seen: list[int] = []
    for time in (5, 7):
        scheduler.add(time, Priority.CALL, lambda _: seen.append(scheduler.now), None)
    scheduler.run_until(10)
    assert seen == [5, 7]


def test_an_event_may_add_another_at_the_same_time() -> None:
    scheduler = Scheduler()
    seen: list[object] = []
    scheduler.add(
        5, Priority.CALL, lambda _: scheduler.add(5, Priority.COMPLETION, seen.append, "added"), None
    )
    scheduler.run_until(5)
    assert seen == ["added"]


def test_run_while_stops_between_events_when_its_predicate_does() -> None:
    scheduler = Scheduler()
    seen: list[int] = []
    for time in range(10):
        scheduler.add(time, Priority.CALL, seen.append, time)
    assert scheduler.run_while(lambda: len(seen) < 3, None)
    assert (seen, scheduler.now, scheduler._events[0][0]) == ([0, 1, 2], 2, 3)


def test_run_while_stops_at_its_limit() -> None:
    scheduler = Scheduler()
    seen: list[int] = []
    for time in (5, 10, 15):
        scheduler.add(time, Priority.CALL, seen.append, time)
    assert not scheduler.run_while(lambda: True, 10)
    assert (seen, scheduler.now) == ([5, 10], 10)


def test_run_while_without_limit_ends_when_nothing_is_left() -> None:
    assert not Scheduler().run_while(lambda: True, None)
