"""Draws the rooms of `src/repro` and their imports, and writes the table of rooms into docs/architecture.md.

python docs/architecture.py           write docs/architecture.svg and the table again, from the source
python docs/architecture.py --check   exit with 1 when one of them is out of date
"""

import ast
import re
import sys
from functools import cache
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "src" / "repro"
PICTURE = ROOT / "docs" / "architecture.svg"
PAGE = ROOT / "docs" / "architecture.md"
TABLE = re.compile(r"(?<=<!-- rooms -->\n).*?(?=<!-- end of rooms -->)", re.DOTALL)

# Of the picture, in px: its width, boxes, the space of an arrow that passes a floor, and the distances between them.
WIDTH, BOX, HEIGHT, BEND, GAP, STEP, MARGIN = 820, 96, 30, 12, 40, 78, 20
EVERYWHERE = ("errors",)  # imported by every room, so not drawn
SWEEPS = 8  # over the floors, to put rooms above those that they import

Arrows = dict[str, set[str]]


@cache
def parsed(path: Path) -> ast.Module:
    """The syntax tree of a file."""
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def imported(path: Path) -> set[str]:
    """Dotted names below `repro` that a file imports: at its head, in a function, or by a string."""
    names = set()
    for node in ast.walk(parsed(path)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            names |= set(re.findall(r"^repro\.[a-z_]+(?:\.[a-z_]+)*", node.value))
    below = {name.removeprefix("repro.") for name in names if name.startswith("repro.")}
    return {
        name for name in below if (SOURCE / name.split(".")[0]).is_dir() or name.split(".")[0] in ("__main__", "errors")
    }


def room_of(path: Path) -> str:
    """The folder of a file below src/repro, or the name of a file that is in none."""
    return path.relative_to(SOURCE).parts[0].removesuffix(".py")


def arrows() -> Arrows:
    """Room -> rooms that it imports."""
    rooms: Arrows = {}
    for path in sorted(SOURCE.rglob("*.py")):
        room = room_of(path)
        rooms.setdefault(room, set()).update({name.split(".")[0] for name in imported(path)} - {room})
    return rooms


def floors(rooms: Arrows) -> dict[str, int]:
    """Number of rooms on the longest chain of imports below each room, itself included; ValueError for a circle."""
    below: dict[str, int] = {}

    def floor(room: str, above: tuple[str, ...] = ()) -> int:
        if room in above:
            raise ValueError(f"circle of imports: {' -> '.join((*above, room))}")
        if room not in below:
            below[room] = 1 + max((floor(other, (*above, room)) for other in rooms[room]), default=0)
        return below[room]

    return {room: floor(room) for room in rooms}


def drawn() -> tuple[Arrows, dict[str, int]]:
    """The rooms of the picture with their floors."""
    rooms = {room: others - {*EVERYWHERE} for room, others in arrows().items() if room not in (*EVERYWHERE, "__init__")}
    return rooms, floors(rooms)


def reduced(rooms: Arrows) -> Arrows:
    """The arrows without those that a longer way replaces."""
    reach: Arrows = {}

    def reachable(room: str) -> set[str]:
        if room not in reach:
            reach[room] = rooms[room].union(*map(reachable, rooms[room]))
        return reach[room]

    return {room: others - set().union(*map(reachable, others)) for room, others in rooms.items()}


def routes(rooms: Arrows, floor: dict[str, int]) -> list[list[str]]:
    """Each arrow as the nodes that it passes: its rooms, and between them one bend on every floor that it crosses."""
    return [
        [room, *(f"{room} {other} {level}" for level in range(floor[room] - 1, floor[other], -1)), other]
        for room, others in sorted(rooms.items())
        for other in sorted(others)
    ]


def positions(ways: list[list[str]], floor: dict[str, int]) -> dict[str, tuple[float, float]]:
    """Centre of each node in px: floors from the bottom, nodes of a floor in the order of those that they touch."""
    level = {node: floor.get(node) or int(node.split()[-1]) for way in ways for node in way}
    top = max(level.values())
    rows = [sorted(node for node in level if level[node] == height) for height in range(1, top + 1)]
    touched: Arrows = {node: set() for node in level}
    for node, other in (pair for way in ways for pair in pairwise(way)):
        touched[node].add(other)
        touched[other].add(node)

    def across(row: list[str]) -> dict[str, float]:
        """A bend takes less room than a box."""
        widths = [BOX if node in floor else BEND for node in row]
        gap = min(GAP, (WIDTH - sum(widths)) / len(row))
        left = (WIDTH - sum(widths) - gap * (len(row) - 1)) / 2
        return {node: left + sum(widths[:i]) + gap * i + widths[i] / 2 for i, node in enumerate(row)}

    x = {node: place for row in rows for node, place in across(row).items()}
    for _ in range(SWEEPS):
        for row in (*rows, *reversed(rows)):
            row.sort(key=lambda node: (sum(x[other] for other in touched[node]) / len(touched[node]), node))
            x |= across(row)
    return {node: (round(x[node]), MARGIN + HEIGHT / 2 + STEP * (top - level[node])) for node in level}


def picture() -> str:
    """The rooms as an SVG: an arrow points from a room to one that it imports."""
    rooms, floor = drawn()
    ways = routes(reduced(rooms), floor)
    centre = positions(ways, floor)
    height = 2 * MARGIN + HEIGHT + STEP * (max(floor.values()) - 1)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height:.0f}" font-family="sans-serif">',
        "<title>Rooms of src/repro; an arrow points to what is imported</title>",
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
        '<path d="M0 1 7 4 0 7z" fill="#444"/></marker></defs>',
        f'<rect width="{WIDTH}" height="{height:.0f}" fill="#fff"/>',
        '<g fill="none" stroke="#444" marker-end="url(#tip)">',
    ]
    lines += [f'<path d="{_curve([centre[node] for node in way])}"/>' for way in ways]
    lines.append('</g>\n<g font-size="14" text-anchor="middle">')
    for room in sorted(rooms):
        x, y = centre[room]
        corner = f'x="{x - BOX / 2:.0f}" y="{y - HEIGHT / 2:.0f}"'
        lines.append(f'<rect {corner} width="{BOX}" height="{HEIGHT}" rx="4" fill="#f2f2f2" stroke="#222"/>')
        lines.append(f'<text x="{x:.0f}" y="{y + 5:.0f}" fill="#111">{room}</text>')
    return "\n".join([*lines, "</g>", "</svg>", ""])


def _curve(points: list[tuple[float, float]]) -> str:
    """A path from the lower edge of the first box to the upper edge of the last, vertical on every floor."""
    (x, y), path = points[0], ""
    for number, (to_x, to_y) in enumerate(points[1:], start=1):
        start = y + HEIGHT / 2
        end = to_y - HEIGHT / 2 - (1 if number == len(points) - 1 else 0)
        middle = (start + end) / 2
        path += f"{'L' if path else 'M'}{x:.0f} {start:.0f}"
        path += f"C{x:.0f} {middle:.0f} {to_x:.0f} {middle:.0f} {to_x:.0f} {end:.0f}"
        x, y = to_x, to_y
    return path


def table() -> str:
    """The rooms from the top floor down: what each holds, by its docstring, and what it imports."""
    rooms, floor = drawn()
    lines = ["| floor | room | holds | imports |", "|---|---|---|---|"]
    for room in sorted(rooms, key=lambda room: (-floor[room], room)):
        path = SOURCE / room / "__init__.py" if (SOURCE / room).is_dir() else SOURCE / f"{room}.py"
        text = (ast.get_docstring(parsed(path)) or "").splitlines()[0]
        lines.append(f"| {floor[room]} | `{room}` | {text} | {', '.join(sorted(rooms[room]))} |")
    return "\n".join([*lines, ""])


def main(arguments: list[str]) -> int:
    """Write or check both files."""
    page = PAGE.read_text(encoding="utf-8")
    written = {PICTURE: picture(), PAGE: TABLE.sub(lambda _: table(), page)}
    outdated = [path for path, text in written.items() if not path.exists() or path.read_text(encoding="utf-8") != text]
    if "--check" in arguments:
        for path in outdated:
            print(f"{path.relative_to(ROOT)} is out of date: run python docs/architecture.py")
        return 1 if outdated else 0
    for path in outdated:
        path.write_text(written[path], encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
