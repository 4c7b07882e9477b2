"""The interface for Python in five lines: a case, its steady train, its stability, a report.

Run time. About half a minute on two cores, the first time some more for compilation.

Command. ``python examples/five_lines.py``
"""

from celltrain import Train, print_report, stability, steady

train = Train(diameter=6, packing=0.2, cells=8)
base = steady(train)
result = stability(base)
print_report(result)
