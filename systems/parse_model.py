"""Parse a model file whose meshes are of kinds that Drake does not read."""

from __future__ import annotations

import hashlib
import logging
import os
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from xml.parsers import expat

from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex

from contact_toolkit import MeshError
from systems.plant.mesh_files import CONVERTED, converted, default_cache

_log = logging.getLogger("contact_toolkit")

_REFERENCES = {"mesh": ("filename", "file"), "texture": ("filename", "file"), "hfield": ("file",)}


def parse_model(
    parser: Parser | MultibodyPlant, path: str | Path, *, cache: str | Path | None = None
) -> list[ModelInstanceIndex]:
    """Add the models of a URDF, SDFormat or MJCF file, whatever its meshes are.

    Drake's collision meshes are .obj, .gltf or .vtk: an .stl ends in "MakeConvexHull only applies
    to ...". Here .stl, .ply, .off and .glb meshes are first written as .obj files into a cache, and
    a copy of the model that names these is parsed. A file without such meshes is parsed as it is.

    Files that the model includes are parsed by Drake as they are.

    Parameters
    ----------
    parser
        Drake's parser, with whatever packages it knows, or a plant.
    path
        The model file.
    cache
        The folder for what is written; `$XDG_CACHE_HOME/contact-toolkit` (`~/.cache/...`) unless
        given.

    Returns
    -------
    list[ModelInstanceIndex]
        The models added.

    Raises
    ------
    MeshError
        For a mesh that is missing or broken; model file and mesh file are named.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from pydrake.multibody.plant import MultibodyPlant
    >>> from systems import parse_model
    >>> plant = MultibodyPlant(time_step=0.001)
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "arm.urdf"
    ...     _ = file.write_text('<robot name="arm"><link name="hand"/></robot>')
    ...     models = parse_model(plant, file)
    >>> plant.GetModelInstanceName(models[0])
    'arm'
    """
    if isinstance(parser, MultibodyPlant):
        parser = Parser(parser)
    return parser.AddModels(str(readable_model(parser, Path(path), cache)))


def readable_model(parser: Parser, path: Path, cache: str | Path | None = None) -> Path:
    """Return a file that `parser` reads: `path`, or what `parse_model` has written in its place.

    The parser is told of the package that the file is in. Parameters and errors are those of
    `parse_model`.
    """
    if not path.is_file():
        raise ValueError(f"{path}: no such file")
    try:
        root = _read(path)
    except expat.ExpatError as error:
        raise ValueError(f"{path}: not XML ({error})") from error
    for folder in path.resolve().parents:
        if (folder / "package.xml").is_file():
            name = _package_name(folder / "package.xml")
            if name and not parser.package_map().Contains(name):
                parser.package_map().Add(name, str(folder))
    folder = (default_cache() if cache is None else Path(cache)).resolve()
    replaced = _Rewriter(path, root, parser, folder).run()
    if not replaced:
        return path
    text = ET.tostring(root, encoding="unicode")
    _log.info("%s: %d meshes written as .obj into %s", path, replaced, folder)
    digest = hashlib.sha256(text.encode()).hexdigest()[:20]
    target = folder / "models" / f"{path.stem}-{digest}{path.suffix}"
    target.parent.mkdir(parents=True, exist_ok=True)
    partial = target.with_suffix(f".{os.getpid()}.tmp")
    partial.write_text(text)
    partial.replace(target)
    return target


def _read(path: Path) -> ET.Element:
    """Return the root of an XML file with all names as written, for Drake goes by these.

    `drake:` stays `drake:`, and need not be declared.
    """
    tree, parser = ET.TreeBuilder(), expat.ParserCreate()
    parser.StartElementHandler = tree.start
    parser.EndElementHandler = tree.end
    parser.CharacterDataHandler = tree.data
    parser.Parse(path.read_bytes(), True)
    return tree.close()


class _Rewriter:
    def __init__(self, path: Path, root: ET.Element, parser: Parser, cache: Path) -> None:
        self._path = path
        self._root = root
        self._packages = parser.package_map()
        self._cache = cache
        self._is_mjcf = self._root.tag == "mujoco"

    def run(self) -> int:
        """Replace references; return how many are to converted meshes. All become absolute."""
        references = list(self._references())
        meshes = [reference for reference in references if reference.is_mesh]
        count = sum(Path(each.get()).suffix.lower() in CONVERTED for each in meshes)
        if not count:
            return 0
        for each in references:
            given = each.get()
            if not given:
                continue
            file = self._resolve(given, each.folder)
            if each.is_mesh and file.suffix.lower() in CONVERTED:
                each.set(str(self._convert(file, given)))
            elif "://" not in given:
                each.set(str(file))
        return count

    def _convert(self, file: Path, given: str) -> Path:
        try:
            return converted(file, self._cache)
        except MeshError as error:
            raise MeshError(f"{self._path}: mesh {given!r}: {error}") from error

    def _resolve(self, given: str, folder: str) -> Path:
        if given.startswith(("package://", "model://")):
            return Path(self._packages.ResolveUrl(given))
        given = given.removeprefix("file://")
        return (self._path.resolve().parent / folder / given).resolve()

    def _references(self) -> Iterator[_Reference]:
        compiler = self._root.find("compiler") if self._is_mjcf else None
        options = {} if compiler is None else compiler.attrib
        assets = options.get("assetdir", "")
        folders = {
            "mesh": options.get("meshdir", assets),
            "hfield": options.get("meshdir", assets),
            "texture": options.get("texturedir", assets),
        }
        for element in self._root.iter():
            if element.tag in _REFERENCES:
                folder = folders[element.tag] if self._is_mjcf else ""
                for name in _REFERENCES[element.tag]:
                    if name in element.attrib:
                        yield _Reference(element, name, element.tag == "mesh", folder)
            uri = element.find("uri") if element.tag in ("mesh", "include") else None
            if uri is not None:
                yield _Reference(uri, None, element.tag == "mesh", "")
            if element.tag == "include" and "file" in element.attrib:
                yield _Reference(element, "file", False, "")


class _Reference:
    """An attribute or a text that names a file."""

    def __init__(self, element: ET.Element, name: str | None, is_mesh: bool, folder: str) -> None:
        self._element = element
        self._name = name
        self.is_mesh = is_mesh
        self.folder = folder

    def get(self) -> str:
        text = self._element.text if self._name is None else self._element.attrib[self._name]
        return (text or "").strip()

    def set(self, value: str) -> None:
        if self._name is None:
            self._element.text = value
        else:
            self._element.attrib[self._name] = value


def _package_name(file: Path) -> str:
    try:
        return (_read(file).findtext("name") or "").strip()
    except expat.ExpatError:
        return ""
