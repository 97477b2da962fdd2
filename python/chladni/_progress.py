"""Progress of long work."""

from contextlib import contextmanager
from sys import stderr


@contextmanager
def told(progress, title):
    """Argument `progress` of the compiled half: a function, a bar of tqdm (lines on stderr without it), or nothing."""
    if progress is not True:
        yield progress or None
        return
    try:
        from tqdm.auto import tqdm
    except ImportError:
        yield lambda stage: print(f"{title}: {stage}", file=stderr)
        return
    with tqdm(desc=title, unit=" stages") as bar:

        def tell(stage):
            bar.set_postfix_str(stage)
            bar.update()

        yield tell
