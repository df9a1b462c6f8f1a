"""Threads of Python: others run while a world steps, and a world has one user at a time."""

import threading
import time

import drystone as ds
import pytest


def beside(work: "threading.Thread") -> int:
    """Counts how often this thread has a turn while another works."""
    turns = 0
    work.start()
    while work.is_alive():
        turns += 1
        time.sleep(0.001)
    work.join()
    return turns


@pytest.mark.parametrize("kind", ["world", "batch"])
def test_other_threads_run_while_a_step_is_computed(kind: str) -> None:
    """A call that held the lock of the interpreter would leave this thread a turn or two."""
    one: ds.World | ds.Batch
    one = ds.World("large_pyramid") if kind == "world" else ds.Batch("tower", 64, threads=1)
    start = time.perf_counter()
    one.step(n=5)
    steps = int(5 * 0.5 / max(time.perf_counter() - start, 1e-3)) + 1
    # Half a second of work has a place for hundreds of turns of a millisecond.
    assert beside(threading.Thread(target=one.step, kwargs={"n": steps})) > 20


@pytest.mark.parametrize("kind", ["world", "batch"])
def test_two_threads_in_one_world_are_an_error_and_it_stays_whole(kind: str) -> None:
    one: ds.World | ds.Batch
    one = ds.World("large_pyramid") if kind == "world" else ds.Batch("tower", 16, threads=1)
    errors: list[Exception] = []

    def work() -> None:
        try:
            one.step(n=60)
        except Exception as error:
            errors.append(error)

    thread = threading.Thread(target=work)
    thread.start()
    refused = False
    while thread.is_alive():
        try:
            one.state_hash()
        except RuntimeError as error:
            assert f"the {kind} is in use by another thread" in str(error)
            refused = True
    thread.join()
    assert refused
    # The worker may have met this thread at its start.
    assert all(isinstance(error, RuntimeError) for error in errors)
    one.step()


def test_worlds_of_their_own_step_in_threads_with_the_same_bits() -> None:
    alone = ds.World("tower")
    alone.step(n=60)
    worlds = [ds.World("tower") for _ in range(4)]
    threads = [threading.Thread(target=world.step, kwargs={"n": 60}) for world in worlds]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert {world.state_hash() for world in worlds} == {alone.state_hash()}
