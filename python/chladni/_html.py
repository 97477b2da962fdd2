"""Small tables for notebooks."""

from html import escape

# rows of a table; what comes after is counted
_ROWS_SHOWN = 60


def table(caption, header, rows):
    """An HTML table of texts and numbers."""
    head = "".join(f"<th>{escape(str(cell))}</th>" for cell in header)
    body = "".join("<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows[:_ROWS_SHOWN])
    more = f"<p>and {len(rows) - _ROWS_SHOWN} more</p>" if len(rows) > _ROWS_SHOWN else ""
    return f"<table><caption>{escape(caption)}</caption><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}"


def frf_set(frf):
    """Size, axis and kind of an FRF set."""
    responses, references, lines = frf.values.shape
    axis = f"{frf.frequency_hz[0]:.6g} to {frf.frequency_hz[-1]:.6g}" if lines else "none"
    return table("FRF set", ["Responses", "References", "Lines", "Hz", "Kind"], [[responses, references, lines, axis, frf.kind or "unknown"]])


def model(found):
    """The table of modes."""
    rows = [
        [n + 1, f"{f:.6g}", f"±{1.96 * df:.2g}", f"{loss:.4g}", f"±{1.96 * dloss:.2g}", trust, "; ".join(reasons)]
        for n, (f, df, loss, dloss, trust, reasons) in enumerate(
            zip(found.frequency_hz, found.frequency_std_hz, found.loss_factor, found.loss_factor_std, found.trust, found.reasons)
        )
    ]
    return table(repr(found), ["Mode", "Frequency, Hz", "95 %", "Loss factor", "95 %", "Trust", "Reasons"], rows)


def rendering(drive):
    """The table of weights."""
    rows = [[name, f"{abs(w):.4g}", f"{_degrees(w):.1f}"] for name, w in zip(drive.references, drive.weights)]
    return table(repr(drive), ["Actuator", "Amplitude", "Phase, °"], rows)


def _degrees(value):
    import cmath
    import math

    return math.degrees(cmath.phase(value))
