"""Export: calibrations and files as other tools' files, and pages of results."""

import functools
import time
from urllib.parse import urljoin

from starlette.responses import Response

from calibdb.errors import GoneError, InvalidError, NotFoundError
from calibdb.http import application
from calibdb.http.application import Call, json_response, route
from calibdb.http.part_checks import read_file
from calibdb.lookup.result_page import read_reported, shared_page
from calibdb.schema import CalibrationDocument, ConvertRequest, ExportQuery

_AS_IT_IS = {"X-Conversion-Error": "0", "X-Conversion-Coverage": "1"}

_PAGE_LIMIT_S, _MAX_PAGE_BYTES = 3.0, 200_000
_PAGE_TTL_S = 60
_PAGE_HEADERS = {"Cache-Control": f"public, max-age=0, s-maxage={_PAGE_TTL_S}"}


def show(call: Call) -> Response:
    """Calibration in the requested format; computing counts as a view."""
    token = call.api_token()
    asked = call.query(ExportQuery)
    if asked.without or not asked.plain:
        call.service.charge(token, "views", call.address)
    store, calibration_id = call.store, call.path("id")
    document = store.calibrations.get(calibration_id)
    if document is not None and (reason := store.calibrations.withdrawal(document)) is not None:
        raise GoneError("This calibration was withdrawn.", kind="withdrawn", extensions={"reason": reason})
    if asked.plain and not asked.without:
        known = read_reported(store, calibration_id, document)
        return json_response(known, headers=_AS_IT_IS)
    return _compute(call, document, asked)


def _compute(call: Call, document: CalibrationDocument | None, asked: ExportQuery) -> Response:
    # Other requests do not load the solver.
    from calibdb.compute import exports
    from calibdb.compute.values import in_time

    name = "without" if asked.without else "format"
    slow = "takes longer to compute than a request may; ask for a larger picture, or another format"
    with in_time(call, InvalidError.field(name, slow)):
        if document is not None and asked.without:
            document = exports.refit_without(document, asked.without)
        known = read_reported(call.store, call.path("id"), document)
        if asked.without:
            if document is None:
                raise InvalidError.field("without", "a consensus has no views of its own")
            known = known.model_copy(update={"id": None})
        if asked.plain:
            return json_response(known, headers=_AS_IT_IS)
        return exports.file_response(exports.to_file(known, document, asked))


def convert(call: Call) -> Response:
    """Another program's file in the requested format; counts as a view."""
    token = call.api_token()
    asked = call.json(ConvertRequest)
    call.service.charge(token, "views", call.address)
    from calibdb.compute import exports
    from calibdb.compute.values import in_time

    slow = "takes longer to convert than a request may; ask for another format"
    with in_time(call, InvalidError.field("format", slow)):
        return exports.file_response(exports.convert_file(asked))


def show_page(call: Call) -> Response:
    """Page of results, with the title of one."""
    language = call.request.path_params.get("language", "")
    if language and not (len(language) == 2 and language.isascii() and language.isalpha()):
        raise NotFoundError("The site has no such page.")
    address = urljoin(call.service.settings.guidance_url, f"/{language}/result/index.html".replace("//", "/"))
    page = _site_page(address, int(time.time() / _PAGE_TTL_S))
    if calibration_id := call.request.query_params.get("id"):
        page = shared_page(page, call.store, calibration_id)
    return Response(page, 200, _PAGE_HEADERS, "text/html")


@functools.lru_cache(maxsize=8)
def _site_page(address: str, _period: int) -> str:
    return read_file(address, _PAGE_LIMIT_S, _MAX_PAGE_BYTES).decode()


handler = application.handler(
    route("/v1/calibrations/{id}", GET=show),
    route("/v1/convert", POST=convert),
    route("/result/index.html", GET=show_page),
    route("/{language}/result/index.html", GET=show_page),
)
