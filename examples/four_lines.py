"""The interface for Python in four lines: a case, its stability, a report.

Run time. Three seconds, the first time some more for compilation.

Command. ``python examples/four_lines.py``
"""

from celltrain import Train, show, stability

train = Train(diameter=6, packing=0.2, cells=8)
result = stability(train)
show(result)
