"""Surfaces made finer, so that a coarse mesh is drawn as the smooth body that it stands for."""
import numpy as np

MOST = 50000  # triangles from which no surface is made finer


def _butterfly(triangles):
    """For each edge the vertices and weights from which its middle is made, as arrays (edges, 8),
    its ends, (edges, 2), and the triangles of the finer mesh.

    The modified butterfly scheme (Zorin, Schröder & Sweldens, SIGGRAPH 1996): a smooth surface
    through all vertices. Raises KeyError where the surface is not closed.
    """
    opposite = {}
    for a, b, c in triangles.tolist():
        opposite[a, b], opposite[b, c], opposite[c, a] = c, a, b
    valence = np.bincount(triangles.ravel())

    def from_one_end(v, other):
        # All weight but 3/4 is on the ring about v, counterclockwise from the other end.
        k = int(valence[v])
        if k == 3:
            ring = [5 / 12, -1 / 12, -1 / 12]
        elif k == 4:
            ring = [3 / 8, 0, -1 / 8, 0]
        else:
            angle = 2 * np.pi * np.arange(k) / k
            ring = (0.25 + np.cos(angle) + 0.5 * np.cos(2 * angle)) / k
        terms, at = {v: 0.75}, other
        for weight in ring:
            terms[at] = terms.get(at, 0) + weight
            at = opposite[v, at]
        return terms

    def stencil(a, b):
        special = [(v, other) for v, other in ((a, b), (b, a)) if valence[v] != 6]
        terms = {}
        if special:
            for v, other in special:
                for at, weight in from_one_end(v, other).items():
                    terms[at] = terms.get(at, 0) + weight / len(special)
            return terms
        c, d = opposite[a, b], opposite[b, a]
        for at, weight in ((a, 1 / 2), (b, 1 / 2), (c, 1 / 8), (d, 1 / 8),
                           (opposite[c, b], -1 / 16), (opposite[a, c], -1 / 16),
                           (opposite[d, a], -1 / 16), (opposite[b, d], -1 / 16)):
            terms[at] = terms.get(at, 0) + weight
        return terms

    ends = [edge for edge in opposite if edge[0] < edge[1]]
    stencils = [stencil(a, b) for a, b in ends]
    widest = max(map(len, stencils))
    vertices = np.zeros((len(ends), widest), int)
    weights = np.zeros((len(ends), widest))
    for row, terms in enumerate(stencils):
        vertices[row, :len(terms)] = list(terms)
        weights[row, :len(terms)] = list(terms.values())
    number = {edge: len(valence) + row for row, edge in enumerate(ends)}
    finer = []
    for a, b, c in triangles.tolist():
        ab, bc, ca = (number[min(edge), max(edge)] for edge in ((a, b), (b, c), (c, a)))
        finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    return vertices, weights, np.array(ends), np.array(finer)


class Refinement:
    """A closed mesh with its triangles divided in four until they are many enough.

    `triangles`, shape (m, 3), are those of the finer mesh, whose first vertices are the coarse
    ones.
    """

    def __init__(self, triangles, at_least):
        """`triangles`: of the coarse mesh, counterclockwise from outside. One that is not closed is
        left as it is."""
        self.triangles = np.asarray(triangles)
        self._levels = []
        while len(self.triangles) < min(at_least, MOST):
            try:
                *level, self.triangles = _butterfly(self.triangles)
            except KeyError:
                break
            self._levels.append(level)

    def positions(self, vertices):
        """The finer mesh's vertices, smooth through the coarse ones: (n, 3) -> (N, 3)."""
        for stencil, weights, _ in self._levels:
            vertices = np.concatenate(
                [vertices, np.einsum("es,esk->ek", weights, vertices[stencil])])
        return vertices

    def values(self, values):
        """Values at the finer mesh's vertices, linear between the coarse ones: (n,) -> (N,)."""
        for _, _, ends in self._levels:
            values = np.concatenate([values, values[ends].mean(axis=1)])
        return values


def normals(vertices, triangles):
    """Outward unit normals at the vertices, (n, 3): the mean of the triangles' by their areas."""
    corners = vertices[triangles]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    summed = np.stack([np.bincount(triangles.ravel(), np.repeat(areas[:, k], 3), len(vertices))
                       for k in range(3)], axis=1)
    return summed / np.maximum(np.linalg.norm(summed, axis=1, keepdims=True), 1e-300)


def vertex_areas(vertices, triangles):
    """The area that belongs to each vertex, (n,): a third of its triangles'."""
    corners = vertices[triangles]
    areas = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    return np.bincount(triangles.ravel(), np.repeat(areas / 3, 3), len(vertices))
