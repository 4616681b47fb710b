"""The measured logs, which are kept outside of the project: their folder, where to get them, and their checksums."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

PENDULUM = "double_pendulum_dfki/"
EXCITATIONS = tuple(
    f"{PENDULUM}A0_sysid_open/20220812-{end}"
    for end in (
        "055640-PM_measured.csv.gz",
        "060143-PM_measured.csv",
        "060245-PM_measured.csv",
        "060329-PM_measured.csv",
        "060440-PM_measured.csv",
    )
)
POOR_LOGS = (f"{PENDULUM}C1_sysid/20230629-143339.csv.gz", f"{PENDULUM}C1_sysid/20230629-154220.csv.gz")
MODELS = {name: f"{PENDULUM}published_parameters/design_A.0_model_{name}.yml" for name in ("1.0", "2.0", "2.1")}
DRIVE, PULSES = "emps/DATA_EMPS.mat", "emps/DATA_EMPS_PULSES.mat"
TANKS = "cascaded_tanks/dataBenchmark.csv"
SOURCES = {  # where a folder comes from
    "double_pendulum_dfki": "dfki-ric-underactuated-lab/double_pendulum, commit 947f1c5edd3f",
    "emps": "nonlinearbenchmark.org, or the copy in forgi86/sysid-neural-continuous, commit 956aa7ecd730",
    "cascaded_tanks": "nonlinearbenchmark.org, or the copy in forgi86/sysid-neural-continuous, commit 956aa7ecd730",
}
CHECKSUMS = {
    EXCITATIONS[0]: "72c7b6e0e649599bf3bc2f7ddfab425e3fa4c7cb37fbe3fbccbaf38d47db83df",
    EXCITATIONS[1]: "4ce7fd0a842c3f63513443152aa059ec08f0a05847e4757bf8b1fe7009af0d1e",
    EXCITATIONS[2]: "905adf0d2bcc22b3cbb9a80236f5a822c6e7c794874ee5263ef5e780448d979c",
    EXCITATIONS[3]: "a8fad4acfc7600c2f09437a720dbc70c2808506ab158b792068a7cdcfbb6abd1",
    EXCITATIONS[4]: "0165553dccbf7a3b72ae4741da167a9a0ad4ae41ff295ed537096180c2c21879",
    POOR_LOGS[0]: "718682783f63d5dbc29d3cd4d59698d92966eb3ca6807a265b90eb3bf420f9a5",
    POOR_LOGS[1]: "d4bda2bb7b2cae3a14d0af69e5c4a383bf700e093385f8530d168622e2fa6542",
    MODELS["1.0"]: "65c09304af7885af409454383a2f14f7f48f0724fe0a26ccbc175d2df98365d9",
    MODELS["2.0"]: "2c03ccd07dc64a9d737c1dc5eaa4bc3d51c76f702b6a2164348594de0b35e01e",
    MODELS["2.1"]: "43d14672611ad9cef17e8151d3df18499b140e03106c569490ab9e7a1caa7bef",
    DRIVE: "6cf6814ae14618795da0101aae2bb97ff0c6351b0501b5492751b02b07facf7e",
    PULSES: "0eab75bb1f6b16228ee78791343a88bf9bfd9a51036ac9807d7b5fc11c0e1704",
    TANKS: "ef2388ed822f3aef4aa80d6b0f2b466dd80b361786b3eafc7a2957c31ea323a7",
}


def name_of(file: str) -> str:
    """The name of an excitation: the time of day at which it was recorded."""
    return file.rpartition("/")[2][9:15]


def read_folder(folder: str) -> tuple[dict[str, str], dict[str, str]]:
    """The paths of the logs in a folder whose checksums are right, and the checksums of the others."""
    paths, wrong = {}, {}
    for file, checksum in CHECKSUMS.items():
        path = Path(folder) / file
        if folder and path.is_file():
            own = hashlib.sha256(path.read_bytes()).hexdigest()
            if own == checksum:
                paths[file] = str(path)
            else:
                wrong[file] = own
    return paths, wrong


def read_model(path: str) -> dict[str, float]:
    """The numbers of a published model by letter."""
    lines = Path(path).read_text(encoding="utf-8").splitlines()
    pairs = (line.partition(":") for line in lines if ":" in line)
    return {name.strip(): float(value) for name, _, value in pairs}


# when the module is loaded, so that an answer of the study belongs to the logs that it was computed from
PATHS, WRONG = read_folder(os.environ.get("LOGS", ""))
PUBLISHED_MODELS = {name: read_model(PATHS[file]) for name, file in MODELS.items() if file in PATHS}


def log_path(file: str) -> str:
    """The path of a log, whose checksum is right."""
    source = SOURCES[file.partition("/")[0]]
    if file in WRONG:
        raise ValueError(
            f"The log {file} must be the one of {source}, with the SHA-256 {CHECKSUMS[file]}; this one has "
            f"{WRONG[file]}."
        )
    if file not in PATHS:
        raise FileNotFoundError(
            f"The study needs the log {file} in the folder that LOGS names, as in 'make reports LOGS=FOLDER'; "
            f"it comes from {source}."
        )
    return PATHS[file]
