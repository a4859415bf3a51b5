"""Tasks from many threads to one."""

from __future__ import annotations

import threading
import time

from scenecc.viewing.mail import Mail


def test_tasks_come_in_order_and_the_last_of_a_key_counts() -> None:
    mail, done = Mail(), list[str]()
    for key, word in (("a", "first"), ("b", "second"), ("a", "third"), (object(), "fourth"), (object(), "fifth")):
        mail.post(key, lambda word=word: done.append(word))
    while (task := mail.take(0)) is not None:
        task()
    assert done == ["second", "third", "fourth", "fifth"]


def test_it_waits_for_a_task_no_longer_than_asked() -> None:
    started = time.monotonic()
    assert Mail().take(0.05) is None
    assert 0.04 < time.monotonic() - started < 5


def test_a_task_wakes_who_waits() -> None:
    mail, done = Mail(), list[int]()
    sender = threading.Timer(0.05, lambda: mail.post("a", lambda: done.append(1)))
    sender.start()
    task = mail.take(None)
    sender.join()
    assert task is not None
    task()
    assert done == [1]
