#!/usr/bin/python3
"""The rooms keep apart: no folder includes a header of one that it must not know, and no file
includes itself by way of others.

    includes.py SOURCE [--arrows]     --arrows prints which room includes which
"""
import os
import re
import sys

# Whom each room may include. A room is a folder with sources; "membrane/surface" is the library
# ductile::surface, "drivers/suspension" the library ductile::suspension.
MAY = {
    "fluid/instruction_set": set(),
    "fluid": {"fluid/instruction_set"},
    "membrane/surface": set(),
    "membrane": {"membrane/surface", "fluid/instruction_set"},
    "rigid": {"membrane/surface"},
    "coupling": {"fluid", "fluid/instruction_set"},
}
MAY["drivers/suspension"] = set(MAY)
LIBRARIES = set(MAY)
MAY["drivers/scenario"] = LIBRARIES
MAY["drivers/analysis"] = LIBRARIES
MAY["drivers/checks"] = LIBRARIES | {"drivers/scenario", "drivers/analysis"}
MAY["drivers/output"] = LIBRARIES | {"drivers/scenario", "drivers/analysis"}
MAY["drivers/run"] = LIBRARIES | {"drivers/scenario", "drivers/analysis", "drivers/output"}
MAY["drivers/campaign"] = LIBRARIES | {
    "drivers/" + room for room in ("scenario", "analysis", "checks", "output", "run")
}
MAY["drivers/commands"] = MAY["drivers/campaign"] | {"drivers/campaign"}


def room_of(path):
    """The innermost room that holds the path, or None."""
    rooms = [room for room in MAY if path.startswith(room + "/")]
    return max(rooms, key=len, default=None)


def sources(top):
    for folder in ("fluid", "membrane", "rigid", "coupling", "drivers"):
        for directory, _, files in os.walk(os.path.join(top, folder)):
            for name in files:
                if name.endswith((".hpp", ".cpp")):
                    yield os.path.relpath(os.path.join(directory, name), top)


def includes(top, path, known):
    """Project files that a file includes, as paths below `top`."""
    with open(os.path.join(top, path), encoding="utf-8") as file:
        for name in re.findall(r'^#include ["<]([^">]+)[">]', file.read(), re.MULTILINE):
            beside = os.path.normpath(os.path.join(os.path.dirname(path), name))
            ends = [p for p in known if p == beside or p.endswith("/include/" + name)
                    or p == "drivers/" + name or p.endswith("/bench/" + name)]
            yield from ends[:1]


def cycle(graph):
    """The files of an include cycle, or an empty list."""
    state = {}  # absent: not seen; False: on the way; True: done

    def visit(path, trail):
        state[path] = False
        for other in graph[path]:
            if state.get(other) is False:
                return trail[trail.index(other):] + [other]
            if other not in state:
                found = visit(other, trail + [other])
                if found:
                    return found
        state[path] = True
        return []

    for path in sorted(graph):
        if path not in state:
            found = visit(path, [path])
            if found:
                return found
    return []


def main():
    top = sys.argv[1]
    known = sorted(sources(top))
    graph = {path: sorted(set(includes(top, path, known))) for path in known}
    missing = [room for room in MAY if not any(room_of(path) == room for path in known)]
    offences = [f"no sources found in {room}" for room in missing]
    arrows = set()
    for path, others in graph.items():
        for other in others:
            here, there = room_of(path), room_of(other)
            if here is None or there is None or here == there:
                continue
            arrows.add((here, there))
            if there not in MAY[here]:
                offences.append(f"{path} includes {other}, which {here} must not know")
    around = cycle(graph)
    if around:
        offences.append("include cycle: " + " -> ".join(around))
    if "--arrows" in sys.argv:
        for here in sorted(MAY):
            print(f"{here}: {', '.join(sorted(t for h, t in arrows if h == here)) or '-'}")
    print(f"{len(known)} files, {sum(map(len, graph.values()))} includes among them, "
          f"{len(offences)} offences")
    for offence in offences:
        print(offence)
    return 1 if offences else 0


if __name__ == "__main__":
    sys.exit(main())
