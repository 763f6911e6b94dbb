"""Where the work on feature curves is saved: its session, its curves, and recovery."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from patterndb.geometry.points import Points
from patterndb.system.files import replace_file
from patterndb_sketch.features.edits import FeatureEdits
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.files.networkjson import write_network
from patterndb_sketch.features.registration import FeatureCurves
from patterndb_sketch.features.session import FEATURE_SESSION, FeatureSession
from patterndb_sketch.recovery import Autosave, SessionWriter


class FeatureFiles(SessionWriter[FeatureEdits, FeatureSession]):
    """Writes files into a folder under names that are free; the session always into one."""

    unnamed = "unnamed-features"

    def watch(
        self, edits: FeatureEdits, session: Callable[[FeatureEdits], FeatureSession], mesh: str
    ) -> str:
        """Keep what is drawn on a model from now on in case of a crash, and read what one left.

        edits: as they are now. session: makes the session of some edits. mesh: the name of the
        model's file. Says that there is something; "" if there is not.
        """
        self.autosave = Autosave(
            lambda now: FEATURE_SESSION.encode(session(now)),
            edits,
            session=self.session_path,
            base="" if self.session_path is None else self.known.digest(self.session_path),
            folder=self._folder,
            unnamed=self.unnamed,
        )

        def read(path: Path) -> FeatureSession | str:
            kept = FEATURE_SESSION.read(path)
            return kept if kept.mesh == mesh else (
                f"of another model, {kept.mesh or 'unnamed'}; rename it to end in .session, and "
                "give it as --session with that model to go on from it"
            )  # fmt: skip

        return self.find_recovery(read)

    def read_again(self) -> FeatureSession:
        """Read the session that is in the file by now."""
        if self.session_path is None:
            raise InvalidFeatureError("there is no session to be read: none was saved yet")
        self.known.note(self.session_path)
        return FEATURE_SESSION.read(self.session_path)

    def save_session(self, session: FeatureSession, edits: FeatureEdits) -> str:
        """Replace the session's file, whole or not at all."""
        path = self.session_path or self.free("features", ".session")
        self.replace_session(path, lambda: FEATURE_SESSION.write(path, session))
        self.note_saved(edits, path)
        return f"saved {path}"

    def save_network(self, network: FeatureCurves) -> str:
        """Write a network of curves."""
        if not network.curves:
            return "there is no curve to save"
        path = self.free("curves", ".json")
        write_network(path, network)
        return f"saved {path}"

    def save_lines(self, lines: Mapping[str, Points]) -> str:
        """Write polylines (k, 3) by name to an OBJ file."""
        if not lines:
            return "there is no curve to save"
        path = self.free("curves", ".obj")
        replace_file(path, format_obj_lines(lines))
        return f"saved {path}"


def format_obj_lines(lines: Mapping[str, Points]) -> str:
    """Format polylines by name as an OBJ file; blanks in names become underscores."""
    text: list[str] = []
    count = 0
    for name, points in lines.items():
        text.append(f"o {'_'.join(name.split())}")
        text += [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
        numbers = range(count + 1, count + len(points) + 1)
        text.append("l " + " ".join(map(str, numbers)))
        count += len(points)
    return "\n".join(text) + "\n"
