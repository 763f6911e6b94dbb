"""3MF files, written for printers: one object of triangles in an archive, in millimetres.

    [Content_Types].xml     which parts there are
    _rels/.rels             which of them is the model
    3D/3dmodel.model        vertices, triangles, and one item to build

Quads and other polygons are cut into triangles; what a pattern is made of is lost, so that 3MF is
not read. A unit of the mesh is a millimetre.

Source: 3MF Consortium, "3D Manufacturing Format: Core Specification", version 1.3.
"""

from __future__ import annotations

import io
import zipfile

from ingest.formats.meshformat import MeshFormat, refuse_reading
from patterndb.core.polygonmesh import PolygonMesh

_XML = '<?xml version="1.0" encoding="UTF-8"?>\n'
_MODEL = "3D/3dmodel.model"
_PACKAGE = "http://schemas.openxmlformats.org/package/2006"
_CORE = "http://schemas.microsoft.com/3dmanufacturing"
_TYPES = (
    f'{_XML}<Types xmlns="{_PACKAGE}/content-types">'
    '<Default Extension="rels" '
    'ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" '
    'ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>\n'
)
_LINKS = (
    f'{_XML}<Relationships xmlns="{_PACKAGE}/relationships">'
    f'<Relationship Target="/{_MODEL}" Id="rel0" Type="{_CORE}/2013/01/3dmodel"/>'
    "</Relationships>\n"
)
#: The earliest time that an archive can name: the same mesh is always the same bytes.
_TIME = (1980, 1, 1, 0, 0, 0)


def format_3mf(mesh: PolygonMesh) -> bytes:
    """Return the mesh as the bytes of a 3MF file."""
    # Imported here because it takes a moment that reading need not wait for.
    from patterndb.geometry.triangulation import cut_faces

    triangles, _ = cut_faces(mesh, fan_quads=False)
    lines = [
        f'{_XML}<model unit="millimeter" xml:lang="en-US" xmlns="{_CORE}/core/2015/02">',
        '<resources><object id="1" type="model"><mesh><vertices>',
        *(f'<vertex x="{x!r}" y="{y!r}" z="{z!r}"/>' for x, y, z in mesh.points.tolist()),
        "</vertices><triangles>",
        *(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in triangles.tolist()),
        '</triangles></mesh></object></resources><build><item objectid="1"/></build></model>',
    ]
    parts = {"[Content_Types].xml": _TYPES, "_rels/.rels": _LINKS, _MODEL: "\n".join(lines) + "\n"}
    into = io.BytesIO()
    with zipfile.ZipFile(into, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in parts.items():
            entry = zipfile.ZipInfo(name, _TIME)
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, text)
    return into.getvalue()


FORMAT = MeshFormat(
    "3MF",
    (".3mf",),
    "an archive for printers, a unit is a millimetre; polygons cut into triangles, written only",
    refuse_reading("3MF"),
    format_3mf,
)
