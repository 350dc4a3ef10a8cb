"""A scene of boxes that scripts of edits move, and the fragments as the changes have them."""
from cli_program import polygon_area


class Solid:
    """A box in a Python scene, which is moved here as the script moves it there."""

    def __init__(self, low, high):
        self.home = [tuple((low, high)[k >> axis & 1][axis] for axis in range(3)) for k in range(8)]
        self.faces = [
            (0, 2, 3, 1),
            (4, 5, 7, 6),
            (0, 1, 5, 4),
            (2, 6, 7, 3),
            (0, 4, 6, 2),
            (1, 3, 7, 5),
        ]
        self.matrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]
        self.there = True

    def move(self, by):
        for axis in range(3):
            self.matrix[4 * axis + 3] += by[axis]

    def corners(self):
        rows = [self.matrix[4 * axis : 4 * axis + 4] for axis in range(3)]
        return [
            tuple(sum(a * b for a, b in zip(row, v)) + row[3] for row in rows) for v in self.home
        ]


def obj_text(solids):
    text, base = "", 1
    for name, solid in solids.items():
        if not solid.there:
            continue
        text += "o %s\n" % name
        text += "".join("v %.17g %.17g %.17g\n" % v for v in solid.corners())
        text += "".join("f %s\n" % " ".join(str(base + i) for i in face) for face in solid.faces)
        base += 8
    return text


class Mirror:
    """The fragments of every light, from nothing but the changes."""

    def __init__(self):
        self.fragments, self.areas = {}, {}

    def apply(self, change):
        light = self.fragments.setdefault(change["light"], {})
        for key in map(tuple, change["gone"]):
            del light[key]
        for added in change["added"]:
            key = tuple(added["id"])
            assert key not in light, key
            light[key] = added
        for area in change["areas"]:
            self.areas[change["light"], area["face"]] = area

    def count(self):
        return sum(len(light) for light in self.fragments.values())

    def lit_areas(self, light):
        sums = {}
        for f in self.fragments.get(light, {}).values():
            key = f["object"], f["number"]
            sums[key] = sums.get(key, 0.0) + (polygon_area(f["corners"]) if f["lit"] else 0.0)
        return sums
