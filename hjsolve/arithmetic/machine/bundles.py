"""Bundles of arrays pass between kernels and their helpers by address.

numba hands a named tuple of arrays over as its words, seven or more for each array: hundreds of them on the stack at
every call of a helper, which took a quarter of all time. So a kernel lays its bundles down in memory once, and helpers
get their addresses; what they read of a bundle is loaded where it is read.
"""

from __future__ import annotations

from collections.abc import Callable

from llvmlite import ir
from numba import extending, types
from numba.core import cgutils
from numba.core.base import BaseContext
from numba.core.datamodel import models
from numba.core.datamodel.manager import DataModelManager
from numba.core.typing.context import BaseContext as TypingContext
from numba.core.typing.templates import AttributeTemplate, Signature, infer_getattr


class BundleAddress(types.Type):
    """The address of a named tuple; attributes are those of the tuple.

    Attributes:
        bundle: numba's type of the tuple.
    """

    def __init__(self, bundle: types.NamedTuple | types.NamedUniTuple):
        self.bundle = bundle
        super().__init__(name=f"address({bundle})")


@extending.register_model(BundleAddress)
class _AddressModel(models.PrimitiveModel):
    """A pointer to the tuple as a value."""

    def __init__(self, manager: DataModelManager, kind: BundleAddress):
        super().__init__(manager, kind, manager.lookup(kind.bundle).get_value_type().as_pointer())


def _passed(kind: types.Type) -> types.Type:
    return BundleAddress(kind) if isinstance(kind, (types.NamedTuple, types.NamedUniTuple)) else kind


@infer_getattr
class _Attributes(AttributeTemplate):
    key = BundleAddress

    def generic_resolve(self, address: BundleAddress, name: str) -> types.Type | None:  # type: ignore[override]
        fields = address.bundle.fields
        return _passed(address.bundle.types[fields.index(name)]) if name in fields else None


@extending.lower_getattr_generic(BundleAddress)
def _attribute(
    _context: BaseContext, builder: ir.IRBuilder, kind: BundleAddress, pointer: ir.Value, name: str
) -> ir.Value:
    place = kind.bundle.fields.index(name)
    part = cgutils.gep_inbounds(builder, pointer, 0, place)
    return part if isinstance(_passed(kind.bundle.types[place]), BundleAddress) else _loaded(builder, part)


def _loaded(builder: ir.IRBuilder, pointer: ir.Value) -> ir.Value:
    """Return a value of several words, word by word: LLVM leaves out those that nobody reads."""
    kind = pointer.type.pointee
    if not isinstance(kind, (ir.LiteralStructType, ir.ArrayType)):
        return builder.load(pointer)
    value, count = ir.Constant(kind, ir.Undefined), len(kind.elements) if hasattr(kind, "elements") else kind.count
    for k in range(count):
        value = builder.insert_value(value, _loaded(builder, cgutils.gep_inbounds(builder, pointer, 0, k)), k)
    return value


@extending.intrinsic
def by_address(_context: TypingContext, arguments: types.Tuple) -> tuple[Signature, Callable[..., ir.Value]]:
    """Return a tuple with an address in place of each bundle; they are laid down where this is called."""
    made = types.Tuple([_passed(kind) for kind in arguments])

    def generate(context: BaseContext, builder: ir.IRBuilder, _signature: Signature, given: list[ir.Value]) -> ir.Value:
        parts = []
        for k, kind in enumerate(arguments):
            part = builder.extract_value(given[0], k)
            held = isinstance(_passed(kind), BundleAddress)
            parts.append(cgutils.alloca_once_value(builder, part) if held else part)
        return context.make_tuple(builder, made, parts)

    return made(arguments), generate
