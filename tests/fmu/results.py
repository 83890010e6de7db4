"""Reads result files of one run back with pyarrow, pandas and scipy and holds them against each other."""

import csv
import json
import pathlib
import sys

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from scipy.io import loadmat
from scipy.signal import firwin

folder = pathlib.Path(sys.argv[1])


def read_csv(name):
    """Names, units and columns of a CSV; Python's own reading of each number is exact."""
    with open(folder / name, newline="") as file:
        rows = list(csv.reader(file))
    heads = [head[:-1].rsplit(" [", 1) for head in rows[0]]
    numbers = np.array([[float(cell) for cell in row] for row in rows[1:]])
    return [head[0] for head in heads], [head[1] for head in heads], numbers.T


def same(a, b):
    return a.dtype == b.dtype and np.array_equal(a, b, equal_nan=True) and np.array_equal(np.signbit(a), np.signbit(b))


names, units, columns = read_csv("double.csv")
assert len(names) > 60 and columns.shape[1] == 1002, columns.shape
table = pq.read_table(folder / "double.parquet")
assert table.column_names == names
for name, column in zip(names, columns):
    assert table.schema.field(name).type == pa.float64() and table.column(name).null_count == 0
    assert same(table.column(name).to_numpy(), column), name
assert json.loads(table.schema.metadata[b"units"]) == dict(zip(names, units))
frame = pd.read_parquet(folder / "double.parquet")
assert frame.index.name == "time" and list(frame.columns) == names[1:] and frame.attrs["units"] == dict(zip(names, units))
assert same(frame.index.to_numpy(), columns[0])

# Single precision: the nearest number; times and distances stay double, but in a MAT file, whose matrix has one precision.
single = pq.read_table(folder / "single.parquet")
written = read_csv("single.csv")[2]
for name, column, text in zip(names, columns, written):
    exact = name == "time" or name.endswith(".distance")
    found = single.column(name).to_numpy()
    assert same(found, column if exact else column.astype(np.float32)), name
    assert np.array_equal(found, text if exact else text.astype(np.float32), equal_nan=True), name
assert (folder / "single.parquet").stat().st_size < 0.62 * (folder / "double.parquet").stat().st_size

for kind, real in (("double", np.float64), ("single", np.float32)):
    mat = loadmat(folder / f"{kind}.mat", chars_as_strings=False)
    text = lambda key: ["".join(column).rstrip() for column in mat[key].T]
    assert ["".join(row).rstrip() for row in mat["Aclass"]] == ["Atrajectory", "1.1", "", "binTrans"]
    assert text("name") == names and text("description") == [f"[{unit}]" for unit in units]
    assert mat["dataInfo"].dtype == np.int32
    assert mat["dataInfo"].T.tolist() == [[0 if k == 0 else 2, k + 1, 0, -1] for k in range(len(names))]
    assert mat["data_1"].tolist() == [[0.0, 2.001]]
    assert same(mat["data_2"], columns.astype(real)), kind

along = pd.read_parquet(folder / "distance.parquet")
assert along.index.name.endswith(".distance") and along.columns[0] == "time" and along.index.is_monotonic_increasing
assert all(name.endswith((".y", ".distance")) for name in along.columns[1:])

# One row of ten: Kaiser's window for 80 dB, from 0.4 to 0.5 of the new rate, the signal turned about its ends.
thin_names, _, thin = read_csv("thin.csv")
assert thin_names == names and thin.shape[1] == 101
assert same(pq.read_table(folder / "thin.parquet").column(names[5]).to_numpy(), thin[5])
half = int(np.ceil((80 - 7.95) / (2.285 * 2 * np.pi * 0.1 / 10) / 2))
taps = firwin(2 * half + 1, 0.045, window=("kaiser", 0.1102 * (80 - 8.7)), fs=1.0)
assert np.array_equal(thin[0], columns[0][:-1][::10])
for name, full, few in list(zip(names, columns, thin))[1:]:
    even = full[:-1]
    expected = np.convolve(np.pad(even, half, mode="reflect", reflect_type="odd"), taps, mode="valid")[::10]
    assert np.abs(few - expected).max() <= 1e-11 * max(1e-300, np.abs(even).max()), name
print("read back:", len(names), "columns,", columns.shape[1], "rows")

# The table of a sweep: the same as its CSV, nothing where a run has no number.
with open(folder / "sweep.csv", newline="") as file:
    head, *rows = csv.reader(file)
frame = pd.read_parquet(folder / "sweep.parquet")
assert frame.index.name == "run" and list(frame.index) == list(range(6))
names = [name.rsplit(" [", 1)[0] for name in head]
assert list(frame.columns) == names[1:-1]
for place, name in enumerate(names[1:-1], start=1):
    column = frame[name]
    for row, value in zip(rows, column):
        cell = row[place]
        assert str(value) == cell if column.dtype.kind not in "f" else (np.isnan(value) if cell == "" else float(cell) == value), (name, cell, value)
assert set(frame["state"]) == {"ok", "refused"} and frame["contact.friction"].dtype == float and set(frame["contact.creep.law"]) == {"kalker_linear", "usetab"}
assert frame.attrs["units"]["max:*.verticalForce"] == "N"
