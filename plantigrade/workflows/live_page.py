"""A live page while something computes beside it: until Ctrl-C, a fault, or the end."""

from collections.abc import Callable
from threading import Event, Thread

from plantigrade.pages.page_server import ServedPage


def look_on(
    page: ServedPage,
    work: Callable[[], object],
    name: str,
    stop: Event,
    failed: list[BaseException],
    *,
    tell: Callable[[str], None],
    show: Callable[[str], object] | None,
    save: Callable[[], None],
    end: Callable[[], object] = lambda: None,
) -> None:
    """Compute in a thread and show the page until interrupted; then end both.

    Args:
        work: What computes until ``stop`` is set.
        stop: Ends both.
        failed: Its fault is appended here.
        tell: Called with the address.
        show: Opens the page at an address; None to open none.
        save: Called when the page asks for it.
        end: Tells ``work`` of the end, where ``stop`` does not.
    """

    def guarded() -> None:
        try:
            work()
        except BaseException as error:
            failed.append(error)
            stop.set()

    thread = Thread(target=guarded, name=name)
    thread.start()
    try:
        tell(f"Live at {page.address} (press Ctrl-C to stop)")
        if show is not None:
            show(page.address)
        while not stop.is_set():
            page.show(stop)
            if page.save_requested.is_set():
                save()
                page.save_requested.clear()
    except KeyboardInterrupt:
        pass
    finally:
        stop.set()
        end()
        thread.join()
        page.close()
