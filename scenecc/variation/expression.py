"""Expressions: tokens are checked, Python's `ast` parses, and its nodes become closures.

Python's parser accepts more than an expression may contain, warns about valid text, and can run out of memory or stack
on hostile text. So it only gets short, shallow text made of known tokens. Python code is never compiled or executed: a
closure applies one operation to the results of its operands.
"""

from __future__ import annotations

import ast
import keyword
import math
import operator
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, suggest
from scenecc.variation import operations
from scenecc.variation.operations import FUNCTIONS, MAX_ARGUMENTS, NUMBERS, ExpressionError, Span

MAX_CHARACTERS = 1000
"""Longest expression, in characters."""

MAX_BRACKET_DEPTH = 30
"""Deepest nesting of brackets."""

_TOKEN = re.compile(
    r"""(?P<space>[ \t\r\n]+)
    |(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)
    |(?P<name>[A-Za-z_][A-Za-z0-9_]*)
    |(?P<string>'(?:[^'\\\r\n\ud800-\udfff]|\\[\\'"nt])*'|"(?:[^"\\\r\n\ud800-\udfff]|\\[\\'"nt])*")
    |(?P<operator>\*\*|//|<=|>=|==|!=|[-+*/%<>,])
    |(?P<open>[(\[])
    |(?P<close>[)\]])
    |(?P<end>\})""",
    re.VERBOSE,
)
_WORDS = frozenset(("and", "or", "not", "if", "else", "True", "False"))
_REFUSED = frozenset(keyword.kwlist) - _WORDS
_PAIRS = {"(": ")", "[": "]"}
_HINTS = {
    ".": "an element is `v[0]`, and the number is `pi`; a condition of `expect` reads `position('NAME')`",
    "?": "a choice is written `a if condition else b`",
    "^": "a power is written `a ** b`",
    "&": "write `and`",
    "|": "write `or`",
    "!": "write `not`, or `!=` between two values",
    "$": "names are written without `$`",
}
_REASONS = {
    ".": "attributes are not allowed in an expression",
    ":": "neither slices nor `:=` are allowed in an expression",
    "=": "a comparison is written `==`",
    "{": "braces are not allowed in an expression",
    "#": "comments are not allowed in an expression",
    "\\": "a backslash is only allowed in a string, as \\\\, \\', \\\", \\n or \\t",
}


def find_end(text: str, start: int) -> int:
    """The position of the `}` that ends the expression whose first character is at `start`.

    Raises:
        ExpressionError: there is no `}`, or an invalid token before it.
    """
    limit = min(len(text), start + MAX_CHARACTERS + 1)
    opened: list[tuple[str, int]] = []
    before, at = "space", start
    while at < limit:
        found = _TOKEN.match(text, at, limit)
        if found is None:
            raise _unreadable(text, start, at, limit)
        kind, token = str(found.lastgroup), found.group()
        match kind:
            case "number" | "string":
                _check_literal(kind, token, before, at)
            case "name" if token in _REFUSED or before == "number":
                if before == "number":
                    raise ExpressionError("invalid number", at, found.end(), f"write `*{token}` to multiply")
                raise ExpressionError(f"`{token}` is not allowed in an expression", at, found.end())
            case "open":
                opened.append((_PAIRS[token], at))
                if len(opened) > MAX_BRACKET_DEPTH:
                    raise ExpressionError(f"more than {MAX_BRACKET_DEPTH} nested brackets", at, at + 1)
            case "close":
                if not opened or opened.pop()[0] != token:
                    raise ExpressionError(f"`{token}` has no opening bracket", at, at + 1)
            case "end":
                if opened:
                    raise ExpressionError("this bracket is never closed", opened[-1][1], opened[-1][1] + 1)
                return at
            case _:
                pass
        # Two strings separated by a space are still adjacent.
        before = before if kind == "space" and before == "string" else kind
        at = found.end()
    raise _endless(text, start, limit)


def _check_literal(kind: str, token: str, before: str, at: int) -> None:
    end = at + len(token)
    if kind == "number":
        if before in {"number", "name"}:
            raise ExpressionError("invalid number", at, end)
        if token.isdecimal() and token[0] == "0" and token.strip("0"):
            raise ExpressionError("a number is written without leading zeros", at, end)
    elif before == "name":
        raise ExpressionError("strings cannot have a prefix", at, end)
    elif before == "string":
        raise ExpressionError("two strings side by side", at, end, "a comma or `+` is missing")


def _unreadable(text: str, start: int, at: int, limit: int) -> ExpressionError:
    found = text[at]
    if found in "'\"":
        if limit == start + MAX_CHARACTERS + 1:
            return _endless(text, start, limit)
        hint = r"a string ends on its own line, and a backslash in it is followed by \, ', " + '", n or t'
        return ExpressionError("this string cannot be read", at, at + 1, hint)
    shown = found if found.isprintable() else ascii(found)[1:-1]
    message = _REASONS.get(found, f"`{cut(shown)}` is not allowed in an expression")
    return ExpressionError(message, at, at + 1, _HINTS.get(found))


def _endless(text: str, start: int, limit: int) -> ExpressionError:
    if limit < len(text) or limit > start + MAX_CHARACTERS:
        return ExpressionError(f"an expression has at most {MAX_CHARACTERS} characters", start, limit)
    hint = "close it with `}`; write `$${` for the characters themselves"
    return ExpressionError("`${` is never closed", start - 2, start, hint)


MAX_DEPTH = 100
"""Deepest nesting of operations."""

CONSTANTS: dict[str, Any] = {"pi": math.pi, "true": True, "false": False}

MESH_BOUNDS = "bounds"
"""The bounds of a mesh, `bounds(PATH)`."""

OBSERVATIONS: dict[str, tuple[str, ...]] = {
    "position": ("name",),
    "speed": ("name",),
    "tilt": ("name",),
    "distance": ("a", "b"),
    "touching": ("a", "b"),
    "qpos": ("name", "joint"),
}
"""Quantities of a simulation, and the arguments of each, which are strings."""

_BOUND_CALLS: dict[str, tuple[str, ...]] = {MESH_BOUNDS: ("path",), **OBSERVATIONS}
"""Functions whose value is supplied from outside. Before `(` only, since a parameter may have the same name."""

_FUNCTION_SYNONYMS: dict[str, str] = {
    **dict.fromkeys(("joint", "joint_position", "joint_pos"), "qpos"),
    **dict.fromkeys(("norm", "magnitude"), "hypot"),
    **dict.fromkeys(("velocity", "linear_velocity"), "speed"),
    **dict.fromkeys(("contact", "contacts", "collides", "in_contact"), "touching"),
    **dict.fromkeys(("pose", "pos", "xyz"), "position"),
}
"""Function name in other tools → name here."""

_RANDOM = frozenset(("random", "rand", "uniform", "normal", "gauss", "randint", "choice", "randn"))
"""Functions of other tools that draw values."""


def suggest_variable(name: str, known: Iterable[str]) -> str | None:
    """Returns a hint for an unknown name of a value. `known`: those that there are."""
    if name in {"HOME", "USER", "PWD"}:
        return "environment variables are not read: write a path relative to the scene, or `asset://PATH`"
    return suggest(name, (*CONSTANTS, *known) if name.lower() in CONSTANTS else known)


RESERVED_NAMES = frozenset((*FUNCTIONS, *CONSTANTS, *_WORDS, "scene", "num_scenes"))
"""Names that parameters, loop variables and draws cannot have, besides Python's keywords."""

Environment = Mapping[str, Any]
Closure = Callable[[Environment], Any]


@frozen
class BoundCall:
    """A call whose value is supplied like that of a name, so that an expression needs no files and no engine.

    Attributes:
        function: one of `OBSERVATIONS`, or `MESH_BOUNDS`.
        arguments: of the call.
    """

    function: str
    arguments: tuple[Expression, ...]


@frozen
class Expression:
    """A parsed expression.

    Attributes:
        tree: of the allowed nodes; `span(node)` gives a node's position.
        run: computes its value from those of its names.
        places: first position of each name.
        span: (start, end) of a node in the scalar's text.
        calls: its bound calls, by `bound_name`.
    """

    tree: ast.expr
    run: Closure
    places: Mapping[str, Span]
    span: Callable[[ast.expr], Span]
    calls: Mapping[str, BoundCall]


def parse_expression(text: str, start: int, end: int) -> Expression:
    """Parses the expression between two positions of a scalar's text.

    `find_end` must have checked its tokens.

    Raises:
        ExpressionError: it is invalid.
    """
    source = text[start:end].translate({ord(space): " " for space in "\t\r\n"})
    if not source.strip():
        raise ExpressionError("the expression is empty", start - 2, end + 1)
    try:
        # The parentheses allow a leading space.
        tree = ast.parse(f"({source})", mode="eval").body
    except SyntaxError as error:
        at = min(max(start + (error.offset or 2) - 2, start), end)
        hint = None
        if choice := re.fullmatch(r"\s*if\b(.+?)(?:\bthen\b(.+?)(?:\belse\b(.+))?)?", source):
            found, value, other = (cut(part.strip()) if part else None for part in choice.groups())
            hint = f"a choice is written `{value or 'b'} if {found} else {other or 'c'}`"
        raise ExpressionError("invalid expression", at, min(at + 1, end), hint) from None
    except (MemoryError, RecursionError):
        raise _too_deep(start, end) from None
    compiler = _Compiler(source, start)
    run = compiler.closure(tree, 0)
    return compiler.expression(tree, run)


def bound_name(node: ast.Call) -> str:
    """The name of a bound call in an expression, independent of spaces and quotes."""
    return ast.unparse(node)


class _Compiler:
    """Compiles the nodes of one expression to closures."""

    def __init__(self, source: str, start: int) -> None:
        self.places: dict[str, Span] = {}
        self._calls: dict[str, BoundCall] = {}
        self._source = source
        self._start = start

    def expression(self, tree: ast.expr, run: Closure) -> Expression:
        """The compiled expression."""
        return Expression(tree, run, self.places, self.span, self._calls)

    def span(self, node: ast.expr) -> Span:
        # Python counts bytes, including the added parenthesis.
        first, last = node.col_offset - 1, (node.end_col_offset or node.col_offset) - 1
        if not self._source.isascii():
            coded = self._source.encode()
            first, last = len(coded[:first].decode()), len(coded[:last].decode())
        # A tuple without its own parentheses would include the added ones.
        return self._start + max(first, 0), self._start + min(last, len(self._source))

    def closure(self, node: ast.expr, depth: int) -> Closure:
        """Makes a closure that computes the node's value."""
        if depth > MAX_DEPTH:
            raise _too_deep(*self.span(node))
        compiled = _NODES.get(type(node))
        if compiled is None:
            raise ExpressionError("this is not allowed in an expression", *self.span(node))
        return compiled(self, node, depth + 1)

    def constant(self, node: ast.Constant, _: int) -> Closure:
        value = node.value
        if type(value) in NUMBERS:
            operations.check_finite(value, self.span(node))
        elif type(value) is not bool and type(value) is not str:
            raise ExpressionError("this is not allowed in an expression", *self.span(node))
        return lambda _: value

    def listed(self, node: ast.List, depth: int) -> Closure:
        parts, span = [self.closure(item, depth) for item in node.elts], self.span(node)
        return lambda environment: operations.check_size([part(environment) for part in parts], span)

    def tuple(self, node: ast.Tuple, _: int) -> Closure:
        raise ExpressionError("a list is written in brackets: [a, b]", *self.span(node))

    def binary(self, node: ast.BinOp, depth: int) -> Closure:
        name, span = type(node.op).__name__, self.span(node)
        if name not in operations.BINARY:
            raise ExpressionError("this operator is not allowed in an expression", *span)
        return _binary(name, self.closure(node.left, depth), self.closure(node.right, depth), span)

    def unary(self, node: ast.UnaryOp, depth: int) -> Closure:
        part, span = self.closure(node.operand, depth), self.span(node)
        if isinstance(node.op, ast.Not):
            of = self.span(node.operand)
            return lambda environment: not operations.truth(part(environment), of)
        apply = operations.SIGNS[type(node.op).__name__]
        return lambda environment: apply(part(environment), span)

    def logical(self, node: ast.BoolOp, depth: int) -> Closure:
        """The first operand that is true (`or`) or false (`and`), else the last. Later operands are not evaluated."""
        parts = [(self.closure(value, depth), self.span(value)) for value in node.values]
        until = isinstance(node.op, ast.Or)

        def run(environment: Environment) -> Any:
            value: Any = None
            for part, span in parts:
                value = part(environment)
                if operations.truth(value, span) is until:
                    break
            return value

        return run

    def compared(self, node: ast.Compare, depth: int) -> Closure:
        """A chain of comparisons, `a < b < c`. Operands after the first false one are not evaluated."""
        others = [self.closure(other, depth) for other in node.comparators]
        first, span = self.closure(node.left, depth), self.span(node)
        steps = list(zip([operations.COMPARISONS[type(op).__name__] for op in node.ops], others, strict=True))

        def run(environment: Environment) -> bool:
            a = first(environment)
            for holds, other in steps:
                b = other(environment)
                if not holds(a, b, span):
                    return False
                a = b
            return True

        return run

    def conditional(self, node: ast.IfExp, depth: int) -> Closure:
        test, span = self.closure(node.test, depth), self.span(node.test)
        chosen, otherwise = self.closure(node.body, depth), self.closure(node.orelse, depth)
        return lambda environment: (chosen if operations.truth(test(environment), span) else otherwise)(environment)

    def indexed(self, node: ast.Subscript, depth: int) -> Closure:
        values, index, span = self.closure(node.value, depth), self.closure(node.slice, depth), self.span(node)
        return lambda environment: operations.item_at(values(environment), index(environment), span)

    def name(self, node: ast.Name, _: int) -> Closure:
        """A constant, or a name that is looked up at evaluation. Records its position in `places`."""
        name, span = node.id, self.span(node)
        if name in CONSTANTS:
            value = CONSTANTS[name]
            return lambda _: value
        if name in FUNCTIONS:
            raise ExpressionError(f"`{name}` is a function: write `{name}(…)`", *span)
        return self._lookup(name, span)

    def _lookup(self, name: str, span: Span) -> Closure:
        self.places.setdefault(name, span)

        def run(environment: Environment) -> Any:
            """Looks up the name."""
            try:
                return environment[name]
            except KeyError:
                raise ExpressionError(f"unknown name `{name}`", *span, suggest_variable(name, environment)) from None

        return run

    def call(self, node: ast.Call, depth: int) -> Closure:
        """A call of one of `FUNCTIONS`. Checks the number of arguments."""
        func, span = node.func, self.span(node)
        if not isinstance(func, ast.Name):
            raise ExpressionError("only functions can be called", *self.span(func))
        if func.id in _BOUND_CALLS:
            return self._bound_call(node, func.id, depth)
        if func.id not in FUNCTIONS:
            meant = _FUNCTION_SYNONYMS.get(func.id)
            hint = f"did you mean `{meant}`?" if meant else suggest(func.id, (*FUNCTIONS, *_BOUND_CALLS))
            if func.id in _RANDOM:
                hint = "draw it in a form, without an expression: `{uniform: [low, high]}`, `{choice: [a, b]}`"
            raise ExpressionError(f"unknown function `{func.id}`", *self.span(func), hint)
        function = FUNCTIONS[func.id]
        fewest, most, apply = function.fewest, function.most, function.apply
        parts = [self.closure(argument, depth) for argument in node.args]
        if not fewest <= len(parts) <= most:
            wanted = (
                str(fewest)
                if fewest == most
                else f"{fewest} to {most}"
                if most < MAX_ARGUMENTS
                else f"at least {fewest}"
            )
            noun = "arguments" if most > 1 and most < MAX_ARGUMENTS else "argument"
            raise ExpressionError(f"`{func.id}` takes {wanted} {noun}, not {len(parts)}", *span)
        if len(parts) == 1:
            (part,) = parts
            return lambda environment: apply([part(environment)], span)
        return lambda environment: apply([part(environment) for part in parts], span)

    def _bound_call(self, node: ast.Call, function: str, depth: int) -> Closure:
        arguments, wanted = node.args, len(_BOUND_CALLS[function])
        if len(arguments) != wanted:
            noun = "argument" if wanted == 1 else "arguments"
            raise ExpressionError(f"`{function}` takes {wanted} {noun}, not {len(arguments)}", *self.span(node))
        for name, argument in zip(_BOUND_CALLS[function], arguments, strict=True):
            if function in OBSERVATIONS and not (
                isinstance(argument, ast.Constant) and isinstance(argument.value, str)
            ):
                hint = f"write it in quotes, as in `{function}('cube')`" if isinstance(argument, ast.Name) else None
                message = f"`{name}` of `{function}` must be a string as it is written"
                raise ExpressionError(message, *self.span(argument), hint)
        inner = [_Compiler(self._source, self._start) for _ in arguments]
        parts = [one.expression(part, one.closure(part, depth)) for one, part in zip(inner, arguments, strict=True)]
        name = bound_name(node)
        self._calls[name] = BoundCall(function, tuple(parts))
        return self._lookup(name, self.span(node))


_NODES: dict[type[ast.AST], Callable[[_Compiler, Any, int], Closure]] = {
    ast.Constant: _Compiler.constant,
    ast.Name: _Compiler.name,
    ast.List: _Compiler.listed,
    ast.Tuple: _Compiler.tuple,
    ast.BinOp: _Compiler.binary,
    ast.UnaryOp: _Compiler.unary,
    ast.BoolOp: _Compiler.logical,
    ast.Compare: _Compiler.compared,
    ast.IfExp: _Compiler.conditional,
    ast.Subscript: _Compiler.indexed,
    ast.Call: _Compiler.call,
}
"""Node types that an expression may contain. The token check has excluded comparisons by `in` and `is`."""


_QUICK: dict[str, Callable[[float, float], float]] = {"Add": operator.add, "Sub": operator.sub, "Mult": operator.mul}
_QUICK_BOUND = 1e70
"""Results below this need no further check, whatever their type."""


def _binary(name: str, left: Closure, right: Closure, span: Span) -> Closure:
    apply = operations.BINARY[name]
    if name not in _QUICK:
        return lambda environment: apply(left(environment), right(environment), span)
    quick = _QUICK[name]

    def run(environment: Environment) -> Any:
        """Returns the result directly for plain numbers of moderate size; otherwise the operation checks."""
        a, b = left(environment), right(environment)
        if type(a) in NUMBERS and type(b) in NUMBERS:
            try:
                result = quick(a, b)
            except OverflowError:
                pass
            else:
                if -_QUICK_BOUND < result < _QUICK_BOUND:
                    return result
        return apply(a, b, span)

    return run


def _too_deep(start: int, end: int) -> ExpressionError:
    return ExpressionError(f"the expression is more than {MAX_DEPTH} operations deep", start, end)
