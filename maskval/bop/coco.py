"""A whole file in COCO's layout, as tools for annotation export it: images, annotations and categories."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from maskval.bop.fields import Entry, is_whole
from maskval.errors import InvalidFileError


@dataclass(frozen=True, slots=True)
class Annotated:
    """An annotation and where it belongs.

    Attributes:
        entry: The annotation, with its category_id and segmentation.
        scene_id: Scene.
        im_id: Image in the scene.
        size: Height and width of the image, pixels.
    """

    entry: Entry
    scene_id: int
    im_id: int
    size: tuple[int, int]


def annotations(root: Entry, path: Path) -> Iterator[Annotated]:
    """The annotations of a file, in their order.

    Args:
        root: What the file holds.
        path: The file; where no file_name has the scene's folder, its own folder tells the scene.

    Raises:
        InvalidFileError: If something is missing, stands there twice, or names what is not there.
    """
    images = _images(root["images"], path)
    categories = {category["id"].identifier() for category in root["categories"].elements()}
    for entry in root["annotations"].elements():
        if entry["image_id"].identifier() not in images:
            raise entry["image_id"].error("the id of one of the images")
        if entry["category_id"].identifier() not in categories:
            raise entry["category_id"].error("the id of one of the categories")
        scene_id, im_id, size = images[entry["image_id"].identifier()]
        yield Annotated(entry, scene_id, im_id, size)


def _images(entries: Entry, path: Path) -> dict[int, tuple[int, int, tuple[int, int]]]:
    """Scene, image in the scene, height and width of each image, by its id in the file."""
    images: dict[int, tuple[int, int, tuple[int, int]]] = {}
    taken: dict[tuple[int, int], Entry] = {}
    for entry in entries.elements():
        number = entry["id"].identifier()
        scene_id, im_id = _scene_and_image(entry, path)
        if number in images or (scene_id, im_id) in taken:
            raise InvalidFileError(f"{entry.place}: expected each image once, but id or file_name stand there twice")
        taken[scene_id, im_id] = entry
        images[number] = scene_id, im_id, (entry["height"].identifier(), entry["width"].identifier())
    return images


def _scene_and_image(entry: Entry, path: Path) -> tuple[int, int]:
    """What BOP's layout, SCENE/rgb/IMAGE.png, says of an image; without a number for a name, its id is the image."""
    name = entry["file_name"]
    if not isinstance(name.value, str):
        raise name.error("a text")
    file = PurePosixPath(name.value.replace("\\", "/"))
    scene = next((part for part in (*file.parts[-2::-1], path.resolve().parent.name) if is_whole(part)), None)
    if scene is None:
        raise name.error("SCENE/rgb/IMAGE.png, or this file in the folder of its scene")
    return int(scene), int(file.stem) if is_whole(file.stem) else entry["id"].identifier()
