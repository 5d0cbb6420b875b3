"""Calibrations from elsewhere: objects that the operator wrote, and items where a capture finds them."""

from collections.abc import Iterator

from calibdb.schema import FitRecord, PriorDocument
from calibdb.schema.fields import size_text, zoom_text
from calibdb.store.keys import camera_pk
from calibdb.store.ports import DocumentStore, encoded, read_all

_PRIORS_PREFIX = "priors/"


class Priors(DocumentStore):
    """First guesses, by camera, size, zoom and model."""

    def find(self, camera_key: str, img_size: tuple[int, int], zoom: float, model: str) -> FitRecord | None:
        """Guess, None if there is none: one read."""
        item = self._table.get(camera_pk(camera_key), _sk(img_size, zoom, model), consistent=False)
        return FitRecord.model_validate_json(item["fit"]) if item else None

    def keep(self, document: PriorDocument) -> None:
        """Store the guess, over the previous one."""
        fit = document.fit
        place = f"{size_text(fit.img_size)}~{zoom_text(document.zoom)}~{fit.distortion_model}"
        self._objects.put(f"{_PRIORS_PREFIX}{document.camera_key}/{place}.json", encoded(document))
        self.index(document)

    def index(self, document: PriorDocument) -> None:
        """Write the index item, which follows from the document."""
        fit = document.fit
        pk, sk = camera_pk(document.camera_key), _sk(fit.img_size, document.zoom, fit.distortion_model)
        self._table.put({"pk": pk, "sk": sk, "fit": fit.model_dump_json()})

    def all(self) -> Iterator[PriorDocument]:
        """Yield every guess in the bucket."""
        return read_all(self._objects, _PRIORS_PREFIX, PriorDocument)


def _sk(img_size: tuple[int, int], zoom: float, model: str) -> str:
    return f"PRIOR#{size_text(img_size)}#{zoom_text(zoom)}#{model}"
