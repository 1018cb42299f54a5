"""Files of numbers in rows, read in pieces: text, NumPy arrays and Parquet."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from hashlib import sha256
from tokenize import TokenError
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.lib.format import open_memmap, read_array

from budget.errors import Issue, SpecError
from budget.inputs.reader import is_number, refuse
from budget.inputs.tree import describe
from budget.journal import note_read

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from budget.arrays import Array

PIECE = 16 * 1024 * 1024  # bytes of text that are read at once
ROWS = 250_000  # of an array
MOST_HEAD = 64 * 1024  # bytes of the line of heads
MOST_COLUMNS = 1000
MOST_ALIKE = 3  # faults of one file that are said
SEPARATORS = (",", ";", "\t")
_BEFORE_HEAD = re.compile(r"\s+(?!\[)")  # not before a unit in brackets
BOM = b"\xef\xbb\xbf"
PARQUET = ".parquet"
ARRAYS = {".npy", ".npz", PARQUET}
# What NumPy raises of an array whose head is spoilt: it is read as Python.
SPOILT = (
    *(ValueError, SyntaxError, TokenError, TypeError, KeyError, EOFError),
    *(OverflowError, MemoryError),
)
MOST_REASON = 120  # characters


@dataclass(frozen=True, kw_only=True, eq=False)
class TablePiece:
    """Some rows of a file.

    Attributes
    ----------
    line : int
        Of the first row, as a person counts them.
    values : ndarray, shape (n, columns)
        Finite, of the columns that are wanted, in their order.
    done : float
        How much of the file has been read with it [1].
    """

    line: int
    values: Array
    done: float


class NumberTable:
    """A file of numbers: its heads, if it has some, and its rows in pieces."""

    def __init__(self, path: Path, shown: str) -> None:
        """Open it.

        Raises
        ------
        SpecError
            It cannot be read, or is no such file.
        """
        self.path, self.shown = path, shown
        self.sha256 = ""  # known when all rows have been read
        self.heads: tuple[str, ...] = ()
        self.width = 0
        kind = path.suffix.lower()
        self._kind = kind if kind in ARRAYS else ""
        try:
            note_read(path)
            self.size = path.stat().st_size
            if path.is_dir():
                raise refuse(shown, "is a folder, expected a recording")
            opened = {
                "": self._open_text,
                ".npy": self._open_array,
                PARQUET: self._open_parquet,
            }
            opened.get(self._kind, self._open_archive)()
        except (OSError, *SPOILT) as error:
            reason = getattr(error, "strerror", None) or str(error)[:MOST_REASON]
            message = f"cannot be read ({reason}), expected a recording"
            raise refuse(shown, message) from None

    def pieces(self, wanted: Sequence[int]) -> Iterator[TablePiece]:
        """Yield the rows of some columns.

        Raises
        ------
        SpecError
            Rows that are none, each at its line.
        """
        if not self._kind:
            yield from self._of_text(wanted)
            return
        line = 1
        rows = self._of_parquet if self._kind == PARQUET else self._of_array
        for values, done in rows(wanted):
            bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
            if bad.size:
                column = int(np.flatnonzero(~np.isfinite(values[bad[0]]))[0])
                message = (
                    f"found {values[bad[0], column]}, expected a finite number; "
                    "leave such rows out, gaps are found by stamps or a counter"
                )
                raise self.fault(line + int(bad[0]), wanted[column] + 1, message)
            yield TablePiece(line=line, values=values, done=done)
            line += len(values)
        if not self.sha256:
            self.sha256 = _sha256(self.path)

    def fault(self, line: int, column: int, message: str) -> SpecError:
        """Return the error of one row; of a text its line, else the number of a row."""
        return SpecError(
            (
                Issue(
                    file=self.shown,
                    line=line,
                    column=column,
                    field="" if not self._kind else f"row {line}",
                    message=message,
                ),
            )
        )

    # ---- text ------------------------------------------------------------------------

    def _open_text(self) -> None:
        """Find separator, heads and the first row of numbers."""
        with self.path.open("rb") as stream:
            start = stream.read(MOST_HEAD)
        if not start.strip():
            raise refuse(self.shown, "is empty, expected rows of numbers")
        if b"\0" in start:
            raise refuse(
                self.shown,
                "is neither text nor named as an array, expected CSV, whitespace text, "
                ".npy, .npz or .parquet; save other files as one of these",
            )
        self._skip = len(BOM) if start.startswith(BOM) else 0
        self._line = 1
        heads: list[str] = []
        while True:
            end = start.find(b"\n", self._skip)
            row = start[self._skip : end if end >= 0 else None]
            text = self._decoded(row).strip()
            bare = text.lstrip("#%").strip()
            self._separator = next((one for one in SEPARATORS if one in bare), "")
            cells = _cells(bare, self._separator)
            is_comment = text[:1] in {"#", "%"}
            if text and not is_comment and all(map(_is_number, cells)):
                self.width = len(cells)
                break
            if text and not is_comment and heads and _is_data(cells):
                self.width = len(cells)  # a row that is none is said with the others
                break
            if text and (not is_comment or len(cells) > 1):
                named = cells if self._separator else _BEFORE_HEAD.split(bare)
                heads = [cell.strip().strip('"') for cell in named]
            if end < 0:
                message = (
                    "has no row of numbers, expected some below their heads, as "
                    "time [s],gyro_x [deg/s]"
                )
                raise refuse(self.shown, message)
            self._skip, self._line = end + 1, self._line + 1
        self._check_width()
        self.heads = tuple(heads)
        if heads and len(heads) != self.width:
            message = (
                f"has {self.width} fields below {len(heads)} heads, expected one for "
                "each; a decimal comma is a second field: write 0.5, not 0,5"
            )
            raise self.fault(self._line, 1, message)

    def _decoded(self, row: bytes) -> str:
        """Return a row as text."""
        try:
            return row.decode()
        except UnicodeDecodeError as error:
            message = (
                f"byte 0x{row[error.start]:02x} is not UTF-8; save the file as UTF-8"
            )
            raise self.fault(self._line, error.start + 1, message) from None

    def _of_text(self, wanted: Sequence[int]) -> Iterator[TablePiece]:
        """Yield pieces of text, each up to the end of a line."""
        digest = sha256()
        line, left = self._line, b""
        with self.path.open("rb") as stream:
            digest.update(stream.read(self._skip))
            read = self._skip
            while True:
                data = stream.read(PIECE)
                digest.update(data)
                read += len(data)
                if not data:
                    break
                whole, end, rest = data.rpartition(b"\n")
                if not end:
                    left += data
                    continue
                yield from self._rows(left + whole + end, line, wanted, read)
                line += left.count(b"\n") + whole.count(b"\n") + 1
                left = rest
        if left.strip():
            message = (
                "the last row has no end of line, so that it may have been cut off; "
                "take the row out, or end it"
            )
            raise self.fault(line, 1, message)
        self.sha256 = digest.hexdigest()

    def _rows(
        self, data: bytes, line: int, wanted: Sequence[int], read: int
    ) -> Iterator[TablePiece]:
        """Yield the rows of a piece of text, if there are any."""
        import pandas as pd

        if not data.strip():
            return
        try:
            frame = pd.read_csv(
                io.BytesIO(data),
                header=None,
                sep=self._separator or r"\s+",
                dtype=dict.fromkeys(wanted, np.float64),
                na_filter=False,
                engine="c",
                skipinitialspace=True,
            )
            values = frame[[*wanted]].to_numpy(dtype=float)
        except (ValueError, KeyError, OverflowError):
            raise self._located(data, line, wanted) from None
        is_sound = len(frame.columns) == self.width and np.isfinite(values).all()
        if self._separator:
            each = data.count(self._separator.encode())
            is_sound = is_sound and each == len(values) * (self.width - 1)
        if not is_sound:
            raise self._located(data, line, wanted)
        yield TablePiece(
            line=line, values=values, done=min(read / max(self.size, 1), 1.0)
        )

    def _located(self, data: bytes, line: int, wanted: Sequence[int]) -> SpecError:
        """Return the error of rows that are none: the first of them, and how many."""
        found: list[Issue] = []
        more = 0
        for number, row in enumerate(data.split(b"\n"), start=line):
            text = row.decode(errors="replace").strip()
            if not text:
                continue
            said = self._wrong(text, wanted)
            if said is None:
                continue
            if len(found) == MOST_ALIKE:
                more += 1
                continue
            (issue,) = self.fault(number, *said).issues
            found.append(issue)
        if not found:
            return refuse(self.shown, "has rows that cannot be read as numbers")
        if more:
            last = found.pop()
            message = f"{last.message}; {more} more rows near it are no better"
            (issue,) = self.fault(last.line, last.column, message).issues
            found.append(issue)
        return SpecError(tuple(found))

    def _wrong(self, text: str, wanted: Sequence[int]) -> tuple[int, str] | None:
        """Return what is wrong with a row and in which column, None if nothing is."""
        cells = _cells(text, self._separator)
        if len(cells) != self.width:
            hint = ""
            if len(cells) > self.width and self._separator == ",":
                hint = "; a decimal comma is a second field: write 0.5, not 0,5"
            said = f"has {len(cells)} fields, expected {self.width}{hint}"
            return 1, said
        for place in wanted:
            cell = cells[place].strip().strip('"')
            if not _is_number(cell):
                head = self.heads[place] if self.heads else f"column {place + 1}"
                message = (
                    f"{head}: found {describe(cell)}, expected a finite number; leave "
                    "a row without one out, gaps are found by stamps or a counter"
                )
                if _is_number(cell.replace(",", ".")):
                    message = f"{head}: found {describe(cell)}, write 0.5, not 0,5"
                column = sum(len(one) + 1 for one in cells[:place]) + 1
                return column, message
        return None

    # ---- arrays ----------------------------------------------------------------------

    def _open_array(self) -> None:
        """Map an array into memory."""
        self._array(open_memmap(self.path, mode="r"))

    def _open_archive(self) -> None:
        """Read the arrays of an archive, each a column that its name is the head of."""
        import zipfile
        import zlib

        names, arrays = [], []
        try:
            with zipfile.ZipFile(self.path) as archive:
                for member in archive.namelist():
                    with archive.open(member) as stream:
                        names.append(member.removesuffix(".npy"))
                        arrays.append(read_array(stream, allow_pickle=False))
        except (zipfile.BadZipFile, zlib.error, RuntimeError) as error:
            raise ValueError(str(error)) from None
        if len(arrays) == 1:
            self._array(arrays[0], names)
            return
        if not arrays or any(
            one.ndim != 1 or one.shape != arrays[0].shape or one.dtype.kind not in "iuf"
            for one in arrays
        ):
            message = (
                "has arrays that are no columns, expected one of rows and columns, "
                "or one for each column, all of one length, named by its head"
            )
            raise refuse(self.shown, message)
        self.heads, self.width = tuple(names), len(names)
        self._columns: list[Any] = arrays

    def _open_parquet(self) -> None:
        """Read the names of the columns of a table; its rows are read in batches."""
        try:
            from pyarrow import ArrowException
            from pyarrow.parquet import ParquetFile
        except ImportError:
            message = (
                "is a Parquet file, which pyarrow reads, and there is none here; "
                "pip install 'sins-budget[parquet]', or save it as CSV"
            )
            raise refuse(self.shown, message) from None
        try:
            self._table = ParquetFile(self.path)
        except ArrowException as error:
            raise ValueError(str(error)) from None
        self.heads = tuple(self._table.schema_arrow.names)
        self.width = len(self.heads)
        if not self._table.metadata.num_rows or not self.heads:
            raise refuse(self.shown, "is empty, expected rows of numbers")
        self._check_width()

    def _check_width(self) -> None:
        """Refuse more columns than any recording has."""
        if self.width > MOST_COLUMNS:
            message = f"has {self.width} columns, expected {MOST_COLUMNS} at the most"
            raise refuse(self.shown, message)

    def _of_parquet(self, wanted: Sequence[int]) -> Iterator[tuple[Array, float]]:
        """Yield rows of columns of a table; what is null is nan."""
        from pyarrow import ArrowException, types

        schema = self._table.schema_arrow
        for k in wanted:
            kind = schema.field(k).type
            if not (types.is_floating(kind) or types.is_integer(kind)):
                said = f"found {kind}, expected numbers; stamps in seconds"
                raise self.fault(1, k + 1, f"{self.heads[k]}: {said}")
        n, done = self._table.metadata.num_rows, 0
        names = list(dict.fromkeys(self.heads[k] for k in wanted))
        try:
            for batch in self._table.iter_batches(batch_size=ROWS, columns=names):
                columns = [
                    batch.column(self.heads[k]).to_numpy(zero_copy_only=False)
                    for k in wanted
                ]
                done += batch.num_rows
                yield np.stack(columns, axis=1).astype(float), done / n
        except (ArrowException, OSError) as error:
            message = (
                f"cannot be read ({str(error)[:MOST_REASON]}), expected a recording"
            )
            raise refuse(self.shown, message) from None

    def _array(self, array: Any, names: Sequence[str] = ()) -> None:  # noqa: ANN401
        """Take an array of rows and columns, or one with named fields."""
        if array.dtype.names:
            fields = array.dtype.names
            sound = array.ndim == 1 and all(
                array.dtype[one].kind in "iuf" and not array.dtype[one].shape
                for one in fields
            )
            self.heads = tuple(fields)
            self._columns = [array[one] for one in fields] if sound else []
        else:
            two = 2
            sound = array.ndim in {1, two} and array.dtype.kind in "iuf"
            if sound:
                wide = array[:, None] if array.ndim == 1 else array
                self._columns = [wide[:, k] for k in range(wide.shape[1])]
                self.heads = tuple(names) if wide.shape[1] == 1 else ()
        if not sound or not self._columns or not len(self._columns[0]):
            message = (
                f"has an array of shape {array.shape} and type {array.dtype}, "
                "expected numbers in rows and columns, a row a sample"
            )
            raise refuse(self.shown, message)
        self.width = len(self._columns)
        self._check_width()

    def _of_array(self, wanted: Sequence[int]) -> Iterator[tuple[Array, float]]:
        """Yield rows of columns in memory, or mapped into it."""
        n = len(self._columns[0])
        for start in range(0, n, ROWS):
            some = slice(start, start + ROWS)
            values = [np.asarray(self._columns[k][some], dtype=float) for k in wanted]
            yield np.stack(values, axis=1), min((start + ROWS) / n, 1.0)


def _cells(text: str, separator: str) -> list[str]:
    """Return the cells of a row."""
    return text.split(separator) if separator else text.split()


def _is_data(cells: Sequence[str]) -> bool:
    """Whether most cells are numbers: a row that is spoilt, and no line of heads."""
    return 2 * sum(map(_is_number, cells)) > len(cells)


def _is_number(cell: str) -> bool:
    """Whether a cell is a finite number, in quotes too."""
    return is_number(cell.strip().strip('"'))


def _sha256(path: Path) -> str:
    """Return the digest of a file."""
    digest = sha256()
    with path.open("rb") as stream:
        while data := stream.read(PIECE):
            digest.update(data)
    return digest.hexdigest()
