r"""The plain text of statements as Markdown with formulas: ``N_zu q^n`` becomes $N_{zu} q^n$.

A formula is a run of words each of which consists of symbols; prose stays as it is. In a terminal
the statements are what their files say.
"""

import re
from collections.abc import Iterator

_GREEK = "theta|lambda|alpha|gamma|delta|eta|rho|phi|psi|chi|Phi|Upsilon|Gamma|Delta|Theta"
_FUNCTIONS = "det|rank|deg|gcd|adj|diag|vec|max|min|binomial|mspec|mzeros"
_NAME = rf"(?:{_GREEK}|(?:{_FUNCTIONS})(?![a-z])|z0|[A-Za-z])"
_HAT = r"(?:~|\^(?=[_^]|$|[\s,.;:)\]']|\(k))?"
_SUBSCRIPT = r"(?:_(?:theta|HA|[A-Z]|[a-z]{1,2}|\d+)(?:_[a-z])?(?:,[su](?![a-z]))?)?"
_STAR = r"(?:\^?\*|'+)*"
_POWER = r"(?:\^(?:-?\d?[A-Za-z](?:_[a-z]{1,2})?|-?\d+|\([^()]*\)|[-+](?![\w(])))?"
_SYMBOL = re.compile(rf"({_NAME})({_HAT})({_SUBSCRIPT})({_STAR})({_POWER})({_STAR})")
_OPERATOR = re.compile(
    r"\.\.\.|>=|<=|!=|[)\]](?:\^(?:-?\d+|[a-zT]|\([^()]*\)))|[)\]]'|[-+=<>/|*()\[\],;]|\d+(?:\.\d+)?"
)
_RUN = re.compile(r"[A-Za-z]{2,}")
_PRODUCTS = {"bq", "ap", "xy"}
_ACRONYMS = {"LQG", "IIR", "FIR", "NMP", "UKF", "EKF", "UD", "II", "KF"}
_EQUATION = re.compile(r"\([1-9AB]\.\d+\)(-\([1-9AB]\.\d+\))?")
_WEAK = re.compile(r"[-+=<>/|*()\[\],;.\d]+")
_TEX = {">=": r"\geq ", "<=": r"\leq ", "!=": r"\neq ", "...": r"\ldots ", "*": r"\cdot ", "|": "|"}
_OPENS, _CLOSES = "([", ")]"


def with_formulas(text: str) -> str:
    r"""Write a sentence as Markdown, its formulas between dollars.

    Examples
    --------
    >>> from proofs.output.formulas import with_formulas
    >>> print(with_formulas("D~ has the degree n + n_c, (2.11)."))
    $\tilde{D}$ has the degree $n+n_{c}$, (2.11).
    >>> print(with_formulas("bq + ap = 0 if and only if A^_R is a zero."))
    $bq+ap=0$ if and only if $\hat{A}_{R}$ is a zero.
    """
    words = re.sub(r"\^\([^()]*\)", lambda power: power.group().replace(" ", ""), text).split(" ")
    parts: list[str] = []
    at = 0
    while at < len(words):
        end = _end_of_formula(words, at)
        if end == at:
            parts.append(escaped(words[at]))
            at += 1
            continue
        parts.append(_formula(" ".join(words[at:end])))
        at = end
    return " ".join(parts)


def escaped(text: str) -> str:
    r"""Escape what Markdown would read as markup.

    Examples
    --------
    >>> from proofs.output.formulas import escaped
    >>> print(escaped("D_c* < [x]"))
    D\_c\* \< \[x\]
    """
    return re.sub(r"([\\`*_\[\]<>$|#~^])", r"\\\1", text)


def _end_of_formula(words: list[str], at: int) -> int:
    """Return the index behind the longest formula that begins with a word, its own for none."""
    end, best, depth = at, at, 0
    strong = False
    while end < len(words) and _is_symbols(words, end):
        word = words[end]
        strong = strong or not _WEAK.fullmatch(word.strip('".:'))
        depth += sum(word.count(c) for c in _OPENS) - sum(word.count(c) for c in _CLOSES)
        end += 1
        bare = word.rstrip('".,:;')
        if depth <= 0 and bare and not re.search(r"[-+=<>/]$", bare) and strong:
            best = end
        if depth <= 0 and re.search(r'[.,:;"]$', word) and word != "...":
            break
    return best


def _is_symbols(words: list[str], at: int) -> bool:
    """Whether a word is made of symbols; what can be prose is taken for that."""
    word = words[at]
    if word == "...":
        return True
    word = word.strip('".:')
    after = words[at + 1] if at + 1 < len(words) else ""
    if not word or _EQUATION.search(word) or re.fullmatch(r"\([a-d]\d?\),?|i\)-iv\),?", word):
        return False
    bare = word.strip("(),;")
    if bare in ("a", "A", "I") and word == bare and at >= 0:
        followed = re.match(r"[-+=<>]|and$|is$|has$|sees$", after)
        return bool(followed) and not (bare == "a" and after in ("is", "has"))
    if bare in _ACRONYMS:
        return False
    if bare in _FUNCTIONS.split("|"):
        return bool(after) and _is_symbols(words, at + 1)
    for run in _RUN.findall(re.sub(rf"{_GREEK}|{_FUNCTIONS}|_[a-zA-Z]+|,[su]\b", " ", word)):
        if not (re.fullmatch(r"[A-Z]{2,3}|[a-z]I|[A-Z][vxu]", run) or run in _PRODUCTS):
            return False
    return not _rest(word)


def _rest(word: str) -> str:
    """Return what of a word is no symbol."""
    return re.sub(f"{_SYMBOL.pattern}|{_OPERATOR.pattern}", "", word).strip()


def _formula(text: str) -> str:
    """Write a run of symbols as TeX; marks around it, and a bracket that stands alone, stay out."""
    before, after = "", ""
    while text and text[0] in '"(' and (text[0] == '"' or _excess(text) > 0):
        before, text = before + text[0], text[1:]
    while text and ((text[-1] in '".,:;' and not text.endswith("...")) or _excess(text) < 0):
        after, text = text[-1] + after, text[:-1]
    return f"{before}${_tex(text)}${escaped(after)}"


def _excess(text: str) -> int:
    return sum(text.count(c) for c in _OPENS) - sum(text.count(c) for c in _CLOSES)


def _tex(text: str) -> str:
    text = re.sub(r"\b(\d*[nmlk]) x (\d*[nmlk])\b", r"\1 × \2", text)
    return "".join(_pieces(text)).strip()


def _pieces(text: str) -> Iterator[str]:
    at, depth = 0, 0
    while at < len(text):
        symbol, operator = _SYMBOL.match(text, at), _OPERATOR.match(text, at)
        if symbol:
            yield _symbol(*symbol.groups())
            at = symbol.end()
        elif operator:
            word = operator.group()
            depth += (word == "[") - (word[0] == "]")
            head, _, power = word.partition("^")
            power = power[1:-1] if power.startswith("(") else power
            yield f"{head}^{{{power}}}" if power else _TEX.get(word, word)
            at = operator.end()
        else:
            if text[at] == "×":
                yield r"\times "
            elif text[at] == " ":
                yield _space(text, at, depth)
            at += 1


def _space(text: str, at: int, depth: int) -> str:
    """Put a space between factors, a wide one between entries of a matrix."""
    near = text[at - 1] + text[at + 1 : at + 2]
    if re.search(r"[-+=<>/×]", near):
        return ""
    return r"\;\;" if depth else r"\,"


def _symbol(name: str, hat: str, subscript: str, mark: str, power: str, mark_behind: str) -> str:
    if re.fullmatch(_GREEK, name):
        name = rf"\{name} "
    elif re.fullmatch(_FUNCTIONS, name):
        name = (
            rf"\{name} " if name in ("det", "deg", "gcd", "max", "min") else rf"\mathrm{{{name}}}\,"
        )
    elif name == "z0":
        name = "z_0"
    if hat:
        name = rf"\{'tilde' if hat == '~' else 'hat'}{{{name.strip()}}}"
    if subscript:
        inner = subscript[1:].replace("theta", r"\theta")
        name += f"_{{{inner}}}"
    marks = (mark + mark_behind).replace("^*", "*")
    exponent = power[1:]
    exponent = exponent[1:-1] if exponent.startswith("(") else exponent
    if not exponent and "*" not in marks:
        return name + marks
    marks = marks.replace("'", r"\prime ")
    return f"{name}^{{{marks}{_tex(exponent)}}}"
