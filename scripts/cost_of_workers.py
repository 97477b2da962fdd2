#!/usr/bin/env python3
"""Time of a fit in pieces on many workers, from parts that were measured on one machine.

    scripts/cost_of_workers.py                        # the tables of docs/pieces.md
    scripts/cost_of_workers.py --read 8 --link 0.3    # a storage of 8 GB/s, links of 0.3 GB/s

A pass: every worker reduces its share, as fast as its core or its share of the storage
allows; partials go up a tree, each worker sends its own once. One worker solves: poles in
constant time, shapes and the model file in proportion to the FRFs. Each of the parts is a
straight line; nothing overlaps but reading and reducing.
"""

import argparse

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--lines", type=int, default=1001, help="lines of each FRF")
parser.add_argument("--bytes", type=int, default=8, help="bytes of a value: 8 in single precision, 16 in double")
parser.add_argument("--passes", type=int, default=1, help="1 where a pilot shows the poles, else 2")
parser.add_argument("--reduce", type=float, default=45.0, help="values that a core reduces, 1e6/s")
parser.add_argument("--together", type=float, default=0.95, help="rate of each of the cores of a machine over that of one alone")
parser.add_argument("--read", type=float, default=1.0, help="storage, all workers together, GB/s")
parser.add_argument("--link", type=float, default=1.0, help="link between workers, GB/s")
parser.add_argument("--partial", type=float, default=405.0, help="bytes of a partial for each FRF")
parser.add_argument("--fixed", type=float, default=1.3, help="the rest of a partial, MB")
parser.add_argument("--merge", type=float, default=0.18, help="merging, reading and writing partials, GB/s")
parser.add_argument("--poles", type=float, default=0.5, help="poles and law, s")
parser.add_argument("--shapes", type=float, default=5.0, help="shapes, s for 1e6 FRFs")
parser.add_argument("--model", type=float, default=2.5, help="writing the model, s for 1e6 FRFs")
parser.add_argument("--memory", type=float, default=1.8, help="of the worker that solves, GB for 1e6 FRFs")
parts = parser.parse_args()


def seconds(frfs, workers):
    """Passes, merging, and what one worker does by itself, s."""
    values = frfs * parts.lines
    rate = parts.reduce * 1e6 * (parts.together if workers > 1 else 1.0)
    one_pass = max(values / (rate * workers), values * parts.bytes / (parts.read * 1e9))
    bytes_of_all = frfs * parts.partial + workers * parts.fixed * 1e6
    merging = bytes_of_all * (1.0 / parts.merge + (1.0 / parts.link if workers > 1 else 0.0)) / 1e9
    alone = parts.poles + (parts.shapes + parts.model) * frfs / 1e6
    return parts.passes * one_pass, parts.passes * merging, alone


print("| FRFs | workers | passes | merging | on one worker | whole | over one worker | memory of the one |")
print("|---|---|---|---|---|---|---|---|")
for frfs in (10**6, 10**7, 10**8):
    one = sum(seconds(frfs, 1))
    for workers in (1, 2, 8, 32, 200):
        passes, merging, alone = seconds(frfs, workers)
        whole = passes + merging + alone
        cells = [f"10^{len(str(frfs)) - 1}", workers, f"{passes:.0f} s", f"{merging:.0f} s", f"{alone:.0f} s", f"{whole:.0f} s"]
        cells += [f"{one / whole:.1f}", f"{parts.memory * frfs / 1e6:.0f} GB"]
        print("| " + " | ".join(map(str, cells)) + " |")
