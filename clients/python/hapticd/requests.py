"""What every request of a session is: the Items that are sent, and what is read from their Results. Written once, as generators that yield
what has to be done next (`Step`) and are given what came of it; `Session` carries the steps out by waiting, `AsyncSession` by awaiting."""
from __future__ import annotations

import os
from typing import Any, Callable, Dict, Generator, Generic, Iterable, NamedTuple, Optional, Sequence, TypeVar, Union

from google.protobuf import text_format

from hapticd import scene_file, values
from hapticd.conversation import Conversation
from hapticd.errors import RequestError, enum_name
from hapticd.v1 import answer_pb2, control_pb2, gesture_pb2, scene_pb2, stream_pb2


class Send(NamedTuple):
    """An Item without an answer, as long as it is in order. `at_once`: even where many wait."""

    item: stream_pb2.Item
    at_once: bool = False


class Ask(NamedTuple):
    """An Item with its Result, which comes back; RequestError where it is refused."""

    item: stream_pb2.Item


class Until(NamedTuple):
    """To wait until a condition of the conversation holds; comes back with its value, which is false after `timeout_s`. `survives`: it may
    come to hold in the session after this one."""

    holds: Callable[[Conversation], Any]
    timeout_s: Optional[float] = None
    survives: bool = False


class Look(NamedTuple):
    """To do something with the conversation while nothing else does; comes back with what it returns."""

    action: Callable[[Conversation], Any]


Step = Union[Send, Ask, Until, Look]
T = TypeVar("T")
Work = Generator[Step, Any, T]
Path = Union[str, "os.PathLike[str]"]


class Course(Generic[T]):
    """The way through a request: after `forward`, `step` is to be carried out and what came of it is told by `answer` or `error`; when
    `forward` is false, `value` is what the request came to. What `forward` raises is what the request ended with."""

    def __init__(self, work: Work[T]) -> None:
        self._work = work
        self.answer: Any = None
        self.error: Optional[BaseException] = None
        self.step: Step
        self.value: T

    def forward(self) -> bool:
        answer, error = self.answer, self.error
        self.answer, self.error = None, None
        try:
            self.step = self._work.send(answer) if error is None else self._work.throw(error)
        except StopIteration as done:
            self.value = done.value
            return False
        return True


def told(kind: str) -> Work[Any]:
    """What the server has told of scene, lease or recorder: one of TOLD."""
    return (yield Until(lambda conversation: conversation.info.get(kind), survives=True))


def scene_id(conversation: Conversation) -> Optional[int]:
    """Of the scene that is played; None until the server has told."""
    info: Any = conversation.info.get("scene_info")
    return None if info is None else info.scene_id


def simple(kind: str) -> Work[answer_pb2.Result]:
    """A request without content, by its name in stream.proto."""
    item = stream_pb2.Item()
    getattr(item, kind).SetInParent()
    return (yield Ask(item))


def any_item(item: stream_pb2.Item) -> Work[answer_pb2.Result]:
    return (yield Ask(item))


def acquire(holder: str, take_over: str) -> Work[answer_pb2.LeaseInfo]:
    item = stream_pb2.Item()
    item.acquire.holder, item.acquire.take_over = holder, take_over
    item.acquire.SetInParent()
    return (yield Ask(item)).lease


def subscribe(divisor: int, sections: Iterable[Union[str, int]], max_contacts: Optional[int]) -> Work[None]:
    item = stream_pb2.Item()
    item.subscribe.divisor = divisor
    item.subscribe.sections.extend(_enum(control_pb2.Section, "SECTION_", section) for section in sections)
    if max_contacts is not None:
        item.subscribe.max_contacts = max_contacts
    yield Look(lambda conversation: conversation.states.clear())
    yield Ask(item)


def bring(asset: scene_file.AssetFile) -> Work[None]:
    """Sends what the server does not have of a file."""
    item = stream_pb2.Item()
    item.put_asset.hash, item.put_asset.size = asset.hash, len(asset.content)
    there = (yield Ask(item)).asset.received
    while there < len(asset.content):
        piece = asset.content[there:there + scene_file.PIECE]
        item.put_asset.offset, item.put_asset.bytes = there, piece
        there += len(piece)
        if (yield Ask(item)).asset.received < there:
            raise ConnectionError(f"hapticd has forgotten what it had of {asset.name!r}. Try again")


def load_scene(scene: Path, preset: Optional[str], check_only: bool) -> Work[answer_pb2.SceneInfo]:
    item = stream_pb2.Item()
    file = None
    if isinstance(scene, str) and ("\n" in scene or "{" in scene):
        item.load_scene.text = scene
    elif isinstance(scene, str) and not _names_file(scene):
        item.load_scene.name = scene
    else:
        file = os.fspath(scene)
        item.load_scene.text = _text_of(scene)
        for asset in scene_file.beside(scene, item.load_scene.text):
            yield from bring(asset)
            item.load_scene.assets.add(name=asset.name, hash=asset.hash)
    if preset is not None:
        item.load_scene.preset = _enum(scene_pb2.Preset, "PRESET_", preset)
    item.load_scene.check_only = check_only
    before = yield from told("scene_info")
    try:
        yield Ask(item)
    except RequestError as refusal:
        # The server has read a text, and does not know of what file.
        raise refusal if file is None else refusal.of_file(file) from None
    if not check_only:
        yield Until(lambda conversation: scene_id(conversation) not in (None, before.scene_id))
    return (yield from told("scene_info"))


def set_parameters(path: Union[str, Dict[str, Any]], value: Any, at_tick: Optional[int]) -> Work[None]:
    item = stream_pb2.Item()
    item.set_parameter.SetInParent()
    for name, each in (path if isinstance(path, dict) else {path: value}).items():
        values.fill_value(item.set_parameter.assignments.add(path=name), each)
    if at_tick is not None:
        item.set_parameter.at_tick = at_tick
    yield Ask(item)


def get_parameters(paths: Union[str, Sequence[str]]) -> Work[Any]:
    item = stream_pb2.Item()
    item.get_parameters.paths.extend([paths] if isinstance(paths, str) else paths)
    item.get_parameters.SetInParent()
    found = {each.path: values.read_value(each) for each in (yield Ask(item)).parameters.values}
    return found[paths] if isinstance(paths, str) and paths in found else found


def listing(kind: str) -> Work[Dict[str, str]]:
    """Names with descriptions: "list_scenes", "list_gestures" or "list_recordings"."""
    found = (yield from simple(kind)).listing
    names, descriptions = found.names, found.descriptions
    return dict(zip(names, descriptions)) if len(descriptions) == len(names) else dict.fromkeys(names, "")


def devices() -> Work[Sequence[answer_pb2.DeviceInfo]]:
    return (yield from simple("get_device_info")).devices.devices


def play_gesture(gesture: Union[Path, gesture_pb2.Gesture, None], arm: Optional[str], seed: Optional[int],
                 repeat: Optional[int]) -> Work[None]:
    item = stream_pb2.Item()
    item.play_gesture.SetInParent()
    if isinstance(gesture, gesture_pb2.Gesture):
        item.play_gesture.gesture.CopyFrom(gesture)
    elif isinstance(gesture, str) and not _names_file(gesture):
        item.play_gesture.name = gesture
    elif gesture is not None:
        text_format.Parse(_text_of(gesture), item.play_gesture.gesture)
    if arm is not None:
        item.play_gesture.arm = _enum(gesture_pb2.Arm, "ARM_", arm)
    if seed is not None:
        item.play_gesture.seed = seed
    if repeat is not None:
        item.play_gesture.repeat = repeat
    yield Ask(item)


def record(mode: str, file: str) -> Work[str]:
    item = stream_pb2.Item()
    item.record.mode = _enum(control_pb2.RecordMode, "RECORD_MODE_", mode)
    item.record.file = file
    return (yield Ask(item)).recorded


def poses(rows: Iterable[Sequence[float]], first_tick: Optional[int], tool_id: int) -> Work[int]:
    count = 0
    for batch in values.pose_batches(rows, tool_id, first_tick):
        item = stream_pb2.Item()
        item.pose_batch.CopyFrom(batch)
        yield Send(item)
        count += len(batch.poses)
    return count


def run_item(mode: control_pb2.RunMode, steps: int = 0) -> stream_pb2.Item:
    """A request about virtual time."""
    item = stream_pb2.Item()
    item.run.mode = mode
    item.run.steps = steps
    return item


def _enum(enum: Any, prefix: str, value: Union[str, int]) -> Any:
    """A value by its name, with or without the prefix, in any case. ValueError lists the names."""
    if isinstance(value, int):
        return value
    name = value.upper()
    name = name if name.startswith(prefix) else prefix + name
    if name not in enum.keys():
        raise ValueError(f"{value!r} is none of {', '.join(enum_name(enum, number, prefix) for number in enum.values() if number)}")
    return enum.Value(name)


def _names_file(source: str) -> bool:
    """A path, and no name of something installed: the server opens no file by its path."""
    return "/" in source or source.endswith(".textproto")


def _text_of(path: Path) -> str:
    with open(path, encoding="utf-8") as file:
        return file.read()
