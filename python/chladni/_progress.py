"""Progress of long work."""

from contextlib import contextmanager
from sys import stderr

from . import _chladni


@contextmanager
def told(progress, title):
    """Argument `progress` of the compiled half: a function, a bar of tqdm (lines on stderr without it), or nothing."""
    if progress is None or progress is False or callable(progress):
        yield progress or None
        return
    if progress is not True:
        raise _chladni.refusal("progress", "nothing that can be told of stages", repr(progress), "True, False, None or a function of one text")
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
