"""moto's tables and buckets as the journal sees them: one content per address.

moto keeps DynamoDB and S3 in plain attributes of its backends; this module alone reaches into them.
Local buckets keep the newest version of an object only.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable, Mapping, MutableMapping
from datetime import UTC, datetime
from typing import Any, Self

from moto.core.model import StructureShape
from moto.core.model_instances import model_data
from moto.core.serialize import BaseJSONSerializer
from moto.dynamodb.models import DynamoDBBackend, dynamodb_backends
from moto.dynamodb.models.dynamo_type import DynamoType, Item, LimitedSizeDict
from moto.dynamodb.models.table import Table
from moto.s3.models import FakeKey, S3Backend, s3_backends

from infra.deploy.intrinsics import ACCOUNT, REGION, TemplateError
from tests.aws.emulator.journal import ITEM, OBJECT, Address, Change, Content
from tests.aws.emulator.template import BucketSpec, TableSpec


class Memory:
    """The template's tables and buckets in moto. Not safe from two threads at once; moto is not."""

    def __init__(self, tables: Iterable[TableSpec], buckets: Iterable[BucketSpec]):
        self.reset()
        self._tables: DynamoDBBackend = dynamodb_backends[ACCOUNT][REGION]
        self._buckets: S3Backend = s3_backends[ACCOUNT]["aws"]
        for table in tables:
            self._tables.tables[table.name] = _table(table)
        for bucket in buckets:
            self._buckets.create_bucket(bucket.name, REGION)

    def item_address(self, table: str, attributes: Mapping[str, Any]) -> Address:
        """Return the address of an item, given in DynamoDB's JSON whole or by its key."""
        schema = self._tables.tables[table]
        return Address(ITEM, table, json.dumps([attributes[name]["S"] for name in schema.table_key_attrs]))

    def read(self, address: Address) -> Content | None:
        """Read the current record at an address."""
        if address.kind == OBJECT:
            key = self._buckets.get_bucket(address.container).keys.get(address.key)
            return _object_content(key) if isinstance(key, FakeKey) else None
        item = self._tables.tables[address.container].get_item(*_item_key(address))
        return Content(json.dumps(_plain_map(item.attrs)).encode()) if item else None

    def read_object(self, bucket: str, name: str) -> tuple[bytes, str] | None:
        """Return content and ETag of an object, None where there is none."""
        key = self._buckets.get_bucket(bucket).keys.get(name)
        return (key.value, key.etag.strip('"')) if isinstance(key, FakeKey) else None

    def names(self, bucket: str, prefix: str) -> list[str]:
        """Return the names of the objects that begin with `prefix`."""
        return [name for name in self._buckets.get_bucket(bucket).keys if name.startswith(prefix)]

    def write(self, change: Change) -> None:
        """Let an address hold what the change says, without checks or conditions."""
        if change.address.kind == OBJECT:
            self._write_object(change.address, change.content)
        else:
            self._write_item(change.address, change.content)

    def _write_item(self, address: Address, content: Content | None) -> None:
        table = self._tables.tables[address.container]
        hash_key, range_key = _item_key(address)
        if content is None:
            table.delete_item(hash_key, range_key)
            return
        item = Item(hash_key, range_key, {})
        attributes = LimitedSizeDict()
        for name, value in json.loads(content.body).items():
            # Past LimitedSizeDict's own check, quadratic in the attributes: the item was let in once already.
            dict.__setitem__(attributes, name, DynamoType(value))
        item.attrs = attributes
        if range_key is None:
            table.items[hash_key] = item  # type: ignore[assignment]  # moto types one kind of table only
        else:
            table.items[hash_key][range_key] = item

    def _write_object(self, address: Address, content: Content | None) -> None:
        keys = self._buckets.get_bucket(address.container).keys
        if content is None:
            if address.key in keys:
                keys.pop(address.key)
            return
        about = json.loads(content.about)
        key = FakeKey(
            name=address.key,
            value=content.body,
            account_id=ACCOUNT,
            region_name=REGION,
            bucket_name=address.container,
            version_id="null",
            checksum_value=about["checksum"],
        )
        key.checksum_algorithm = about["checksum_algorithm"]
        key.last_modified = datetime.fromtimestamp(about["modified"], UTC).replace(tzinfo=None)
        key.set_metadata(about["metadata"], replace=True)
        keys.setlist(address.key, [key])

    def forget_instances(self) -> None:
        """Let go of what moto keeps for its dashboard: every item and object that ever was, copies too."""
        for service in ("dynamodb", "s3"):
            for model in model_data[service].values():
                model.instances_tracked.clear()  # type: ignore[attr-defined]

    def reset(self) -> None:
        """Empty moto."""
        dynamodb_backends.reset()
        self.forget_instances()


_SCALARS = frozenset({"S", "N", "BOOL", "NULL"})
_serialize_structure = BaseJSONSerializer._serialize_type_structure


def _serialize_attribute(
    self: BaseJSONSerializer,
    serialized: MutableMapping[str, Any],
    value: Any,
    shape: StructureShape,
    key: str,
) -> None:
    """Take a scalar attribute as it is; moto looks for each of ten types under several names."""
    scalar = key and shape.name == "AttributeValue" and type(value) is dict and len(value) == 1
    if scalar and not value.keys() - _SCALARS:
        serialized[key] = value
    else:
        _serialize_structure(self, serialized, value, shape, key)


BaseJSONSerializer._serialize_type_structure = _serialize_attribute  # type: ignore[method-assign]


class PartitionedTable(Table):
    """A table whose Query looks at one partition, and which has no copies.

    moto's sorts the whole table at each Query, and copies it before each transaction. A refused transaction
    is put back by `Storage`, which knows the addresses.
    """

    partition: DynamoType | None = None

    def __deepcopy__(self, _: dict[int, Any]) -> Self:
        """Return the table itself."""
        return self

    def query(self, hash_key: DynamoType | None, *args: Any, **kwargs: Any) -> Any:
        """Query as moto does, over fewer items; those of an index may lie in any partition."""
        self.partition = hash_key if kwargs.get("index_name") is None and self.has_range_key else None
        try:
            return super().query(hash_key, *args, **kwargs)
        finally:
            self.partition = None

    def all_items(self) -> list[Item]:
        """Return the items that a running Query may see, else all."""
        if self.partition is None:
            return super().all_items()
        partition: dict[DynamoType, Item] = self.items.get(self.partition, {})
        return list(partition.values())


def _table(spec: TableSpec) -> Table:
    kinds = {a["AttributeName"]: a["AttributeType"] for a in spec.properties["AttributeDefinitions"]}
    for key in spec.properties["KeySchema"]:
        if kinds[key["AttributeName"]] != "S":
            # A number has many spellings; an address must have one.
            raise TemplateError(f"{spec.name}: the local stack knows keys of type S only")
    # Abstract are only the parts that CloudFormation would call.
    table = PartitionedTable(  # type: ignore[abstract]
        spec.name,
        account_id=ACCOUNT,
        region=REGION,
        schema=spec.properties["KeySchema"],
        attr=spec.properties["AttributeDefinitions"],
        billing_mode=spec.properties.get("BillingMode"),
        global_indexes=spec.properties.get("GlobalSecondaryIndexes"),
        indexes=spec.properties.get("LocalSecondaryIndexes"),
    )
    if spec.ttl_attribute:
        table.ttl = {"TimeToLiveStatus": "ENABLED", "AttributeName": spec.ttl_attribute}
    return table


def _item_key(address: Address) -> tuple[DynamoType, DynamoType | None]:
    hash_key, *range_key = json.loads(address.key)
    return DynamoType({"S": hash_key}), DynamoType({"S": range_key[0]}) if range_key else None


def _plain_map(attributes: Mapping[str, DynamoType]) -> dict[str, Any]:
    return {name: _plain(value) for name, value in attributes.items()}


def _plain(attribute: DynamoType) -> dict[str, Any]:
    """Return an attribute as DynamoDB's JSON. moto's own `to_json` cannot do bytes below the first level."""
    value: Any = attribute.value
    if attribute.type == "M":
        value = _plain_map(value)
    elif attribute.type == "L":
        value = [_plain(element) for element in value]
    elif isinstance(value, bytes):
        value = base64.b64encode(value).decode("ascii")
    return {attribute.type: value}


def _object_content(key: FakeKey) -> Content:
    about = {
        "metadata": dict(key.metadata),
        "modified": key.last_modified.replace(tzinfo=UTC).timestamp(),
        "checksum_algorithm": key.checksum_algorithm,
        "checksum": key.checksum_value,
    }
    return Content(key.value, json.dumps(about))
