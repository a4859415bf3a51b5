"""Tasks from many threads to one."""

from __future__ import annotations

import contextlib
import signal
import threading

import pytest

from scenecc.viewer.tasks import TaskQueue, interrupts_kept


def test_tasks_run_in_order_and_the_last_of_a_key_counts() -> None:
    mail, done = TaskQueue(), list[str]()
    for key, word in (("a", "first"), ("b", "second"), ("a", "third"), (object(), "fourth"), (object(), "fifth")):
        mail.post(key, lambda word=word: done.append(word))
    while (task := mail.take(0)) is not None:
        task()
    assert done == ["second", "third", "fourth", "fifth"]


def test_taking_a_task_ends_at_the_timeout() -> None:
    assert TaskQueue().take(0.001) is None


def test_a_swallowed_interrupt_is_raised_again() -> None:
    mail, came = TaskQueue(), list[int]()

    def interrupt(number: int, frame: object) -> None:
        came.append(number)
        raise RuntimeError

    before = signal.signal(signal.SIGINT, interrupt)
    try:
        with interrupts_kept(mail):
            with contextlib.suppress(RuntimeError):
                signal.raise_signal(signal.SIGINT)
            task = mail.take(0)
            assert task is not None
            with pytest.raises(RuntimeError):
                task()
        assert signal.getsignal(signal.SIGINT) is interrupt
    finally:
        signal.signal(signal.SIGINT, before)
    assert came == [signal.SIGINT, signal.SIGINT]


def test_a_new_task_wakes_the_waiting_thread() -> None:
    mail, done = TaskQueue(), list[int]()
    sender = threading.Timer(0.05, lambda: mail.post("a", lambda: done.append(1)))
    sender.start()
    task = mail.take(None)
    sender.join()
    assert task is not None
    task()
    assert done == [1]
