"""One line of KUKA Robot Language as a tree. Nothing is decided here about what a statement does."""

import re
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any

from helimag.errors import InputError, MissingExtra

if TYPE_CHECKING:
    import lark

# one statement: the language has one a line, and so messages can name it; of the operators, comparisons bind least
_GRAMMAR = r"""
?start: "GLOBAL"? "DEF" NAME "(" parameters? ")"               -> def_
    | "GLOBAL"? "DEFFCT" NAME NAME "(" parameters? ")"         -> function
    | "DEFDAT" NAME "PUBLIC"?                                  -> defdat
    | ("END" | "ENDFCT")                                       -> end
    | "ENDDAT"                                                 -> enddat
    | ("EXT" | "EXTP") NAME "(" parameters? ")"                -> nothing
    | "EXTFCT" NAME NAME "(" parameters? ")"                   -> nothing
    | "INTERRUPT" "DECL" NUMBER "WHEN" expression "DO" NAME "(" ")" -> interrupt_decl
    | "GLOBAL" "INTERRUPT" "DECL" NUMBER "WHEN" expression "DO" NAME "(" ")" -> interrupt_global
    | "INTERRUPT" "ON" NUMBER                                  -> interrupt_on
    | "INTERRUPT" "OFF" NUMBER?                                -> interrupt_off
    | declaration
    | reference "=" expression                                 -> assign
    | NAME "(" (argument ("," argument)*)? ")"                 -> call
    | "WAIT" "SEC" expression                                  -> wait
    | "WAIT" "FOR" expression                                  -> wait_for
    | "IF" expression "THEN"                                   -> if_
    | "ELSE"                                                   -> else_
    | "ENDIF"                                                  -> endif
    | "FOR" NAME "=" expression "TO" expression ("STEP" expression)? -> for_
    | "ENDFOR"                                                 -> endfor
    | "WHILE" expression                                       -> while_
    | "ENDWHILE"                                               -> endwhile
    | "REPEAT"                                                 -> repeat
    | "UNTIL" expression                                       -> until
    | "LOOP"                                                   -> loop
    | "ENDLOOP"                                                -> endloop
    | "EXIT"                                                   -> exit_
    | "SWITCH" expression                                      -> switch
    | "CASE" expression ("," expression)*                      -> case
    | "DEFAULT"                                                -> default
    | "ENDSWITCH"                                              -> endswitch
    | "RETURN"                                                 -> return_
    | "CONTINUE"                                               -> continue_
    | "HALT"                                                   -> halt
    | "SPLINE" with_?                                          -> spline
    | "ENDSPLINE" ROUNDING*                                    -> endspline
    | ("PTP" | "SPTP") point ROUNDING* with_?                  -> ptp
    | ("LIN" | "SLIN") point ROUNDING* with_?                  -> lin
    | "SPL" point ROUNDING* with_?                             -> spl
    | ("CIRC" | "SCIRC") point "," point ROUNDING* with_?      -> circ
    | "PTP_REL" point ROUNDING*                                -> ptp_rel
    | "LIN_REL" point ROUNDING* WORD?                          -> lin_rel
with_: "WITH" setting ("," setting)*
setting: reference "=" expression
parameters: parameter ("," parameter)*
parameter: NAME (":" DIRECTION)?
declaration: "DECL" "GLOBAL"? CONST? NAME declared ("," declared)*
    | "GLOBAL" CONST? NAME declared ("," declared)*
    | CONST NAME declared ("," declared)*
    | NAME declared ("," declared)*
declared: reference ("=" expression)?
argument: expression
point: expression
?expression: either | either COMPARE either          -> both
?either: exclusive | either OR exclusive             -> both
?exclusive: conjunction | exclusive EXOR conjunction -> both
?conjunction: sum | conjunction AND sum              -> both
?sum: product | sum PLUS product                     -> both
?product: signed | product TIMES signed              -> both
?signed: compound | PLUS signed -> sign | "NOT" signed -> not_
?compound: atom | compound ":" atom                  -> compound
?atom: NUMBER -> number
    | TRUTH -> truth
    | WORD -> word
    | STRING -> string
    | aggregate
    | reference
    | NAME "(" expression ("," expression)* ")" -> function_of
    | "(" expression ")"
aggregate: "{" (NAME ":")? component ("," component)* "}"
component: NAME ("[" "]")? expression
reference: (NAME | SYSTEM) ("[" expression "]")? ("." NAME)* ("[" "]")?
ROUNDING.2: /C_(DIS|VEL|ORI|PTP|SPL)\b/
DIRECTION.2: /(IN|OUT)\b/
CONST.2: /CONST\b/
OR.2: /OR\b/
EXOR.2: /EXOR\b/
AND.2: /AND\b/
TRUTH.2: /(TRUE|FALSE)\b/
COMPARE: "==" | "<>" | "<=" | ">=" | "<" | ">"
PLUS: "+" | "-"
TIMES: "*" | "/"
WORD: /#[A-Z_][A-Z0-9_]*/
STRING: /"[^"]*"/
SYSTEM: /\$[A-Z_][A-Z0-9_]*/
NAME: /[A-Z_][A-Z0-9_]*/
NUMBER: /([0-9]+\.?[0-9]*|\.[0-9]+)(E[-+]?[0-9]+)?/
%ignore /[ \t]+/
"""


_LOOSE = re.compile(r"[=<>].*\b(AND|OR|EXOR)\b.*[=<>]")
DEEPEST = 100  # of a statement's tree

# why a statement that others use is not read
_REASONS = {
    "TRIGGER": "what a TRIGGER switches while the arm moves is not followed",
    "GOTO": "GOTO is not followed; use IF, LOOP or FOR",
    "PTP_SPLINE": "the course of a PTP_SPLINE block is not followed",
    "CIRC_REL": "CIRC_REL is not followed; name the points",
    "SCIRC_REL": "SCIRC_REL is not followed; name the points",
    "SLIN_REL": "SLIN_REL is not followed; name the point",
    "SPTP_REL": "SPTP_REL is not followed; name the joint angles",
    "PULSE": "PULSE is not followed",
    "BRAKE": "BRAKE stops the arm on its way",
    "RESUME": "RESUME leaves a motion unfinished",
    "IMPORT": "IMPORT takes values from a file that is not read",
    "SIGNAL": "SIGNAL stands for inputs and outputs, which are not followed",
    "ANOUT": "ANOUT changes outputs while the arm moves",
    "ANIN": "ANIN reads inputs, which are not known on paper",
}


@cache
def _parser() -> "lark.Lark":
    try:
        import lark
    except ImportError:
        raise MissingExtra.of("reading KRL", "lark", "robot") from None
    return lark.Lark(_GRAMMAR, parser="lalr")


def code_of(written: str) -> str:
    """A line without its comment, in capitals, empty where it holds no code; strings keep their semicolons."""
    inside = False
    for i, character in enumerate(written):
        inside ^= character == '"'
        if character == ";" and not inside:
            written = written[:i]
            break
    return "".join(c.upper() if c.isascii() else c for c in written.strip(" \t\n"))  # other letters are no code


@lru_cache(maxsize=20_000)  # most lines of a programme, and of the many that tests make of one, are the same
def tree_of(code: str) -> "lark.Tree":
    """The tree of one line of code; not to be changed.

    Raises
    ------
    InputError
        Where the line is outside the subset.
    MissingExtra
        Where lark is not installed.
    """
    parser = _parser()
    import lark

    reason = _REASONS.get(code.split(maxsplit=1)[0])
    if reason is not None:
        raise InputError(f"expected a statement of the subset that helimag reads; {reason}; got {code[:80]!r}")
    try:
        tree = parser.parse(code)
    except lark.exceptions.LarkError:
        hint = "; comparisons bind least in KRL: (A==1) AND (B==2)" if _LOOSE.search(code) else ""
        raise InputError(f"expected a statement of the subset that helimag reads{hint}; got {code[:80]!r}") from None
    if _deeper(tree, DEEPEST):
        raise InputError(f"expected expressions at most {DEEPEST} operations deep; got {code[:80]!r}")
    return tree


def _deeper(tree: "lark.Tree", most: int) -> bool:
    """Whether trees stand in trees more than ``most`` times."""
    level: list[Any] = [tree]
    for _ in range(most):
        level = [child for inner in level for child in inner.children if not isinstance(child, str)]
    return bool(level)
