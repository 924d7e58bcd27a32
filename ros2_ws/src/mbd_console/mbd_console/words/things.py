"""Objects as a lay person names them: size, colour, kind, and where in the picture when that leaves several alike."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from mbd_model.objects import Scene, SceneObject

from mbd_console.words.texts import PageTexts

# Things of a kind differ in size for the eye from this ratio of their volumes on.
NOTICED = 1.5
# Endings of German adjectives by gender: without an article, after der/die/das, and that in the accusative.
_ENDINGS = {"m": ("er", "e", "en"), "f": ("e", "e", "e"), "n": ("es", "e", "e")}
_ARTICLES = {"m": ("der", "den"), "f": ("die", "die"), "n": ("das", "das")}


@dataclass(frozen=True)
class ThingName:
    """What to call an object.

    Attributes:
        label: without an article: "big red bowl".
        nominative: with one, as who does something or is something: "the big red bowl", "der große rote Becher".
        accusative: with one, as what is taken or put: "the big red bowl", "den großen roten Becher".
    """

    label: str
    nominative: str
    accusative: str


def thing_names(
    scene: Scene, texts: PageTexts, along: Mapping[str, float], others: Iterable[SceneObject] = ()
) -> dict[str, ThingName]:
    """Names of a scene's objects by id, no two the same.

    Args:
        scene: whose objects are named.
        texts: in which language.
        along: how far to the right each object appears to who sees the page, by id, in any unit; () where unknown.
        others: objects of the other scene: "big" and "small" are said among all that are of a kind.
    """
    sizes = _sizes([*scene.objects, *others])
    words = {o.object_id: (_size(o, sizes), _color(o, texts), _kind(o, texts)) for o in scene.objects}
    alike = defaultdict(list)
    for object_id in words:
        alike[words[object_id]].append(object_id)
    names = {}
    for same in alike.values():
        ordered = sorted(same, key=lambda i: (along.get(i, 0.0), i))
        for number, object_id in enumerate(ordered, start=1):
            names[object_id] = _named(words[object_id], _place(number, len(ordered), texts), texts)
    return names


def operator_names(scene: Scene, texts: PageTexts) -> dict[str, ThingName]:
    """What the operator's pages call each object, by id: colour and kind, with the id where others look alike."""
    names = {thing.object_id: described_in(thing, texts) for thing in scene.objects}
    alike = Counter(name.label for name in names.values())
    for thing in scene.objects:
        if alike[names[thing.object_id].label] > 1 or not (thing.color_name or _is_known(thing)):
            names[thing.object_id] = described_in(thing, texts, thing.object_id)
    return names


def described_in(thing: SceneObject, texts: PageTexts, *after: str) -> ThingName:
    """An object by colour and kind: "blue cup", "blauer Becher"; English as the robot's own questions have it.

    Args:
        thing: the object.
        texts: in which language.
        after: words behind it, as its id.
    """
    color = [texts(name)] if (name := _color(thing, texts)) else [thing.color_name] if thing.color_name else []
    if not _is_known(thing):
        return _composed(color, texts("kind_object"), after, texts)
    name = f"kind_{thing.object_class}"
    plain = thing.object_class.replace("_", " ")
    foreign = f"n {plain}" if texts.language == "de" else plain
    return _composed(color, texts(name) if texts.language == "de" and texts.has(name) else foreign, after, texts)


def _is_known(thing: SceneObject) -> bool:
    return thing.object_class not in ("", "unknown")


def nothing_named(texts: PageTexts) -> ThingName:
    """For an object that nobody knows."""
    return ThingName(texts("this_thing"), texts("this_thing"), texts("this_thing"))


def _sizes(things: Iterable[SceneObject]) -> dict[str, tuple[float, float]]:
    """Least and greatest volume [m^3] of each kind."""
    found: dict[str, list[float]] = defaultdict(list)
    for thing in things:
        found[thing.object_class].append(thing.volume)
    return {kind: (min(v), max(v)) for kind, v in found.items()}


def _size(thing: SceneObject, sizes: Mapping[str, tuple[float, float]]) -> str:
    least, greatest = sizes[thing.object_class]
    if greatest < NOTICED * least:
        return ""
    middle = (least * greatest) ** 0.5
    step = NOTICED**0.25  # those near the middle are neither
    return "size_big" if thing.volume > middle * step else "size_small" if thing.volume < middle / step else ""


def _color(thing: SceneObject, texts: PageTexts) -> str:
    name = f"color_{thing.color_name}"
    return name if texts.has(name) else ""


def _kind(thing: SceneObject, texts: PageTexts) -> str:
    name = f"kind_{thing.object_class}"
    return name if texts.has(name) else "kind_thing"


def _place(number: int, count: int, texts: PageTexts) -> str:
    if count == 1:
        return ""
    if number in (1, count):
        return texts("at_left" if number == 1 else "at_right")
    return texts("at_middle") if count == 3 else texts("at_number", number=number)


def _named(words: tuple[str, str, str], place: str, texts: PageTexts) -> ThingName:
    return _composed([texts(word) for word in words[:2] if word], texts(words[2]), [place] if place else [], texts)


def _composed(adjectives: Sequence[str], kind: str, after: Sequence[str], texts: PageTexts) -> ThingName:
    """A name of its parts; in German ``kind`` begins with its gender, and adjectives get their endings."""
    if texts.language != "de":
        label = " ".join([*adjectives, kind, *after])
        return ThingName(label, f"the {label}", f"the {label}")
    gender, noun = kind.split(" ", 1)
    bare, weak, accusative = (" ".join([*(a + e for a in adjectives), noun, *after]) for e in _ENDINGS[gender])
    nominative_article, accusative_article = _ARTICLES[gender]
    return ThingName(bare, f"{nominative_article} {weak}", f"{accusative_article} {accusative}")
