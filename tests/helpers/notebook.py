"""Execution of a notebook's cells, in order, in one namespace, as a kernel would; without Jupyter."""

import ast
import json
import sys
from pathlib import Path
from typing import Any


def run(path: Path) -> tuple[dict[str, Any], list[bytes]]:
    """Run the code cells, and return their names and the pictures (PNG) that they show."""
    names: dict[str, Any] = {"__name__": "__main__"}
    shown = []
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] != "code":
            continue
        tree = ast.parse("".join(cell["source"]))
        last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
        exec(compile(tree, str(path), "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), str(path), "eval"), names)
            if hasattr(value, "_repr_png_"):
                shown.append(value._repr_png_())
    return names, shown


if __name__ == "__main__":
    _, pictures = run(Path(sys.argv[1]))
    print(json.dumps([len(each) for each in pictures if each.startswith(b"\x89PNG")]))
