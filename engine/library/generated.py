"""Make the kernel that unpacks a table and calls another kernel; only a compiling process needs it.

The code depends only on the kinds of the arguments. The arrays are those to which the words point:
no data is copied, and no reference is counted.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba
from llvmlite import ir
from numba import types
from numba.core import errors
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, intrinsic, lower_getattr_generic, models, register_model

from ghostball.engine.library import table
from ghostball.engine.library.plain_numba import array_in_one_piece
from ghostball.engine.library.reached import REFERENCE_WORDS, mark
from ghostball.engine.library.table import Kind, dtype_of

# Offsets of numpy's fields, in bytes after the head of a Python object: `PyArrayObject_fields` and
# `PyArray_Descr` in numpy/ndarraytypes.h. Programs compiled for any numpy since 1.7 rely on them.
DATA, DIMENSIONS, LENGTHS, DESCRIPTION, FLAGS = 0, 8, 16, 40, 48
NUMBER_OF_TYPE = 12
IN_ONE_PIECE = 0x101
"""The flags C_CONTIGUOUS and ALIGNED of an array."""


WORD, HALF_WORD, FLOAT = ir.IntType(64), ir.IntType(32), ir.DoubleType()


def _loaded(builder: Any, address: Any, kind: Any) -> Any:
    return builder.load(builder.inttoptr(address, kind.as_pointer()))


def _reader(kind: Any, number: Any) -> Any:
    """Return a function that reads LLVM's type `kind` at an address, as numba's type `number`."""

    @intrinsic
    def read_at(_: Any, _address: Any) -> Any:
        def code(_: Any, builder: Any, __: Any, arguments: Any) -> Any:
            value = _loaded(builder, arguments[0], kind)
            return builder.sext(value, WORD) if kind is HALF_WORD else value

        return number(types.int64), code

    return read_at


word_at, float_at = _reader(WORD, types.int64), _reader(FLOAT, types.float64)
half_word_at = _reader(HALF_WORD, types.int64)


@intrinsic
def _put_at(_: Any, _address: Any, value: Any) -> Any:
    """Write a number at an address: integers and booleans as an integer, floats as a float."""
    if not isinstance(value, types.Integer | types.Float | types.Boolean):
        return None

    def code(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        kind = types.float64 if isinstance(value, types.Float) else types.int64
        word = context.cast(builder, arguments[1], value, kind)
        builder.store(word, builder.inttoptr(arguments[0], word.type.as_pointer()))
        return context.get_dummy_value()

    return types.none(types.int64, value), code


put_at: Any = _put_at


def array_maker(element: Any, dimensions: int) -> Any:
    """Return a function that makes numba's array from the numpy array at an address."""
    array = types.Array(element, dimensions, "C")

    @intrinsic
    def array_at(_: Any, _address: Any) -> Any:
        def code(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
            def field(offset: int, base: Any = arguments[0]) -> Any:
                return _loaded(builder, builder.add(base, WORD(offset)), WORD)

            lengths = [field(8 * k, field(LENGTHS)) for k in range(dimensions)]
            return array_in_one_piece(context, builder, array, field(DATA), lengths)

        return array(types.int64), code

    return array_at


class Reference(types.Type):
    """The address of numba's named tuple in memory, which is passed as one word."""

    def __init__(self, target: Any) -> None:
        self.target = target
        super().__init__(name=f"Reference({target.name})")


@register_model(Reference)
class _Address(models.OpaqueModel):
    """A pointer."""


@infer_getattr
class _Fields(AttributeTemplate):
    key = Reference

    def generic_resolve(self, reference: Any, name: str) -> Any:  # type: ignore[override]
        """Return the type of a field."""
        target = reference.target
        return target.types[target.fields.index(name)] if name in target.fields else None


def _field_of(context: Any, builder: Any, reference: Any, address: Any, name: str) -> Any:
    """Load a field."""
    target = reference.target
    whole = context.get_value_type(target).as_pointer()
    place = [HALF_WORD(0), HALF_WORD(target.fields.index(name))]
    return builder.load(builder.gep(builder.bitcast(address, whole), place))


_lowers: Any = lower_getattr_generic
_lowers(Reference)(_field_of)


@intrinsic
def by_reference(_: Any, value: Any, memory: Any) -> Any:
    """Write a named tuple of arrays into memory and return its address."""
    for name, kind in zip(value.fields, value.types, strict=True):
        if not isinstance(kind, types.Array) or kind.layout != "C":
            raise errors.TypingError(
                f"the field `{name}` must be an array in one piece, got {kind}"
            )
    reference = Reference(value)
    words = sum(5 + 2 * kind.ndim for kind in value.types)
    if words > REFERENCE_WORDS:
        raise errors.TypingError(f"{words} words are more than REFERENCE_WORDS, {REFERENCE_WORDS}")

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        room = context.make_array(signature.args[1])(context, builder, arguments[1])
        address = builder.bitcast(room.data, arguments[0].type.as_pointer())
        builder.store(arguments[0], address)
        return builder.bitcast(address, context.get_value_type(reference))

    return reference(value, memory), code


def fits(address: int, head: int, dimensions: int, number: int) -> bool:
    """Return whether a contiguous array of these dimensions and type is at an address."""
    fields = address + head
    return bool(
        half_word_at(fields + DIMENSIONS) == dimensions
        and half_word_at(fields + FLAGS) & IN_ONE_PIECE == IN_ONE_PIECE
        and half_word_at(word_at(fields + DESCRIPTION) + head + NUMBER_OF_TYPE) == number
    )


mark(fits, inline=True)


def unpacking(kernel: Any, fitting: Any, kinds: list[Kind], result: Kind) -> Callable[..., Any]:
    """Return a function that takes the address of a table, and calls `kernel` with its arguments.

    `kernel`, `fitting`: numba's dispatchers of the kernel and of `fits`.
    """
    space: dict[str, Any] = {
        "word_at": word_at,
        "float_at": float_at,
        "put_at": put_at,
        "fits": fitting,
        "kernel": kernel,
    }
    arguments, checks, word = [], [], table.AT_FIRST
    for kind in kinds:
        at = f"table + {8 * word}"
        word += kind != "none"
        if not isinstance(kind, list):
            read = {"none": "None", "float": f"float_at({at})", "int": f"word_at({at})"}
            arguments.append(read.get(kind, f"word_at({at}) != 0"))
            continue
        dtype, dimensions = dtype_of(kind[1]), kind[2]
        checks += [
            f"    if not fits(word_at({at}), head, {dimensions}, {dtype.num}):",
            f"        put_at(table + {8 * table.AT_STATUS}, {word - table.AT_FIRST})",
            "        return 0",
        ]
        maker = f"array_{word}"
        space[maker] = array_maker(numba.from_dtype(dtype), dimensions)
        arguments.append(f"{maker}(word_at({at}) + head)")
    lines = [
        "def unpacked(table):",
        f"    if word_at(table + {8 * table.AT_VERSION}) != {table.VERSION}:",
        "        return 0",
        f"    if word_at(table + {8 * table.AT_LENGTH}) != {word}:",
        "        return 0",
        f"    head = word_at(table + {8 * table.AT_HEAD})",
        *checks,
        f"    put_at(table + {8 * table.AT_STATUS}, {table.ENTERED})",
        f"    result = kernel({', '.join(arguments)})",
        *([] if result == "none" else [f"    put_at(table + {8 * table.AT_RESULT}, result)"]),
        "    return 0",
    ]
    exec("\n".join(lines), space)
    function: Callable[..., Any] = space["unpacked"]
    return function


RESHAPE = """
define i32 @numba_attempt_nocopy_reshape(i64 %nd, ptr %dims, ptr %strides, i64 %count,
                                         ptr %lengths, ptr %steps, i64 %size, i32 %fortran) {
entry:
  br label %head
head:
  %left = phi i64 [ %count, %entry ], [ %place, %body ]
  %step = phi i64 [ %size, %entry ], [ %next, %body ]
  %more = icmp sgt i64 %left, 0
  br i1 %more, label %body, label %end
body:
  %place = sub i64 %left, 1
  %to = getelementptr i64, ptr %steps, i64 %place
  store i64 %step, ptr %to
  %from = getelementptr i64, ptr %lengths, i64 %place
  %length = load i64, ptr %from
  %next = mul i64 %step, %length
  br label %head
end:
  ret i32 1
}
"""
"""The only function of numba that compiled kernels call, as LLVM code.

Kernels reshape only contiguous arrays, so the strides follow from the lengths. Numba's own function
also treats other arrays.
"""
