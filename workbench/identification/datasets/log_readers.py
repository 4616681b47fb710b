"""The files and objects from which a dataset is read, each by a method that calls the file of its reader."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Self

from workbench.core.validation.refusals import whole
from workbench.core.validation.signatures import check_arguments
from workbench.engine.trajectories import Trajectories
from workbench.identification.datasets.csv_reader import read_csv, source_name
from workbench.identification.datasets.experiment import Experiment
from workbench.identification.datasets.frame_reader import read_frame, read_parquet
from workbench.identification.datasets.log_columns import LogChoice, LogColumns
from workbench.identification.datasets.mat_reader import read_mat
from workbench.identification.datasets.mcap_reader import read_mcap
from workbench.identification.datasets.run_reader import experiments_of
from workbench.identification.datasets.ulog_reader import read_ulog

if TYPE_CHECKING:
    import pandas as pd

Names = Mapping[str, str]


class AbstractLogReaders(ABC):
    """The readers of logs, which share the arguments that `from_csv` explains."""

    @classmethod
    @abstractmethod
    def from_experiments(cls, experiments: tuple[Experiment, ...], source: str, notes: Sequence[str]) -> Self:
        """The dataset of experiments from a source, with sentences on what a reader did."""

    @classmethod
    def _read(cls, log: LogColumns, choice: LogChoice, name: str) -> Self:
        return cls.from_experiments((log.experiment(choice.call, name),), log.source, log.notes)

    @classmethod
    @check_arguments
    def from_csv(
        cls,
        path: str | Path,
        signals: Sequence[str] = (),
        *,
        names: Names | None = None,
        units: Names | None = None,
        time: str | float | None = None,
        absent: Sequence[str] = (),
        every: int = 1,
        name: str = "",
    ) -> Self:
        """A dataset from a CSV file, plain or gzipped, with the names and units of its first line.

        The first line is as 't [s],omega [rad/s]', 't (s),omega (rad/s)' or 't:s,omega:rad/s', or units follow it;
        spaces around a name do not count. Tabs, semicolons or commas separate the cells: the first of these that it
        has. Between tabs and semicolons numbers may have decimal commas. An empty cell is NaN: no sample. Lines of #
        are comments. The file is read in parts: its size is limited by the numbers that are kept, 134 million, 1 GiB.

        Parameters
        ----------
        path
            The file.
        signals
            The columns to read, by their names in the file or their new ones; `q` is all of q[0], q[1], ... The default
            is all columns.
        names
            New names of columns, by the names in the file.
        units
            Units of columns without one, by either name. Only a time in ms, us, ns, min or h is converted, into s.
        time
            The column of time; the default is `t` or `time`. Or the period between two lines in s.
        absent
            Texts that stand for a lost sample, such as 'n/a'.
        every
            A whole number n: every n-th line is read.
        name
            The name of the experiment; the default is the name of the file.

        Raises
        ------
        LookupError
            If there is no such file or column, or it cannot be read.
        ValueError
            If the file is no CSV with a first line of names, a cell is no number (named by line and column), a unit
            differs from the file's, or the file holds too many numbers.
        """
        choice = LogChoice("Dataset.from_csv(path=...)", source_name(path), tuple(signals), names, units, time)
        every = whole("Dataset.from_csv(every=...)", every)
        return cls._read(read_csv(path, choice, absent, every), choice, name or _stem(path))

    @classmethod
    @check_arguments
    def from_frame(
        cls,
        frame: pd.DataFrame,
        signals: Sequence[str] = (),
        *,
        names: Names | None = None,
        units: Names | None = None,
        time: str | float | None = None,
        name: str = "table",
    ) -> Self:
        """A dataset from a table of pandas, with heads as `omega [rad/s]` and times in a column or in the index.

        Dates are counted in s from the first one. The arguments are those of `from_csv`.
        """
        choice = LogChoice("Dataset.from_frame(frame=...)", "the table", tuple(signals), names, units, time)
        return cls._read(read_frame(frame, choice), choice, name)

    @classmethod
    @check_arguments
    def from_parquet(
        cls,
        path: str | Path,
        signals: Sequence[str] = (),
        *,
        names: Names | None = None,
        units: Names | None = None,
        time: str | float | None = None,
        name: str = "",
    ) -> Self:
        """A dataset from a Parquet file (extra `data`), with the arguments of `from_csv`."""
        choice = LogChoice("Dataset.from_parquet(path=...)", source_name(path), tuple(signals), names, units, time)
        return cls._read(read_parquet(path, choice), choice, name or _stem(path))

    @classmethod
    @check_arguments
    def from_mat(
        cls,
        path: str | Path,
        signals: Sequence[str] = (),
        *,
        names: Names | None = None,
        units: Names | None = None,
        time: str | float | None = None,
        name: str = "",
    ) -> Self:
        """A dataset from a MAT file of version 5 or older, with the arguments of `from_csv`.

        Its signals are the vectors, and the matrices column by column, that have a row for each time; the variable `u`
        of a structure `data` is `data.u`. A file of version 7.3 is refused.
        """
        choice = LogChoice("Dataset.from_mat(path=...)", source_name(path), tuple(signals), names, units, time)
        return cls._read(read_mat(path, choice), choice, name or _stem(path))

    @classmethod
    @check_arguments
    def from_mcap(
        cls,
        path: str | Path,
        signals: Sequence[str] = (),
        *,
        names: Names | None = None,
        units: Names | None = None,
        time: str | None = None,
        name: str = "",
    ) -> Self:
        """A dataset from an MCAP file, or the folder of a rosbag2 recording in MCAP (extra `logs`).

        A signal is the path of a number in the messages of a topic, `/encoders.position[0]`. Topics come at times
        of their own: the dataset has all times, and NaN where a topic has no message; `resample` brings them together.
        `time` is 'log_time' (the default), 'publish_time' or 'header.stamp'. Messages are those of ROS 2 or JSON. The
        other arguments are those of `from_csv`.
        """
        choice = LogChoice("Dataset.from_mcap(path=...)", source_name(path), tuple(signals), names, units, time)
        return cls._read(read_mcap(path, choice), choice, name or _stem(path))

    @classmethod
    @check_arguments
    def from_ulog(
        cls,
        path: str | Path,
        signals: Sequence[str] = (),
        *,
        names: Names | None = None,
        units: Names | None = None,
        name: str = "",
    ) -> Self:
        """A dataset from a ULog file of PX4 (extra `logs`), with the arguments of `from_csv`.

        A signal is a field of a topic, `vehicle_attitude.q[0]`, or `sensor_accel#1.x` of the second instance. Topics
        come at times of their own, as in `from_mcap`.
        """
        choice = LogChoice("Dataset.from_ulog(path=...)", source_name(path), tuple(signals), names, units)
        return cls._read(read_ulog(path, choice), choice, name or _stem(path))

    @classmethod
    @check_arguments
    def from_runs(cls, runs: Trajectories, signals: Sequence[str] = ()) -> Self:
        """A dataset from simulated runs, an experiment for each, with the states and outputs that are named, or all.

        Raises
        ------
        LookupError
            If there is no such state or output.
        """
        notes = (f"Simulated, and {runs.losses}.",) if runs.losses else ()
        return cls.from_experiments(experiments_of(runs, signals), f"a simulation of '{runs.step.flow.name}'", notes)


def _stem(path: str | Path) -> str:
    name = Path(path).name
    for ending in (".gz", Path(name.removesuffix(".gz")).suffix):
        name = name.removesuffix(ending) if ending else name
    return name
