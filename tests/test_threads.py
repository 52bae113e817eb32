"""Work on two threads."""

from itertools import islice

from wm3d.threads import ahead


def test_work_ahead_comes_in_order_and_stops_soon_after_nobody_asks():
    worked = []

    def squared(number: int) -> int:
        worked.append(number)
        return number**2

    assert list(ahead(squared, [3, 1, 2])) == [9, 1, 4]
    worked.clear()
    assert list(islice(ahead(squared, range(100)), 3)) == [0, 1, 4]
    assert len(worked) <= 4
