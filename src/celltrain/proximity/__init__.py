"""How close cells are to each other, to points, and to the wall. Terms are those of the glossary.

- `nearest`: the point of a surface nearest to a given one, by Newton's method; all else searches
  with it;
- `boxes`: which cells and images can be within a distance at all;
- `chunks`: targets in chunks, and what their boxes are near to;
- `close_pairs`: targets too close to a cell for its ordinary grid, inside programs of JAX;
- `overlaps`: cells that intersect each other, themselves or the wall;
- `surface_grid`: points and area elements of membranes on a grid;
- `own_sides`: parts of one membrane that face each other closely;
- `film_points`: points of membranes in thin films, and the nearest points across them;
- `distances`: of each cell from the nearest other one, and from the wall;
- `meridian`: gaps and clearances of axisymmetric cells; needs no JAX.
"""
