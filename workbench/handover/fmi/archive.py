"""fmu: a law, a plant or a closed loop as one file that other simulators run, after FMI 2.0 or 3.0."""

from __future__ import annotations

import io
import os
import re
import secrets
import zipfile
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from workbench.core import Ode, SampledLaw, SampledSystem
from workbench.core.validation.places import other_kind
from workbench.core.validation.refusals import describe, one_of
from workbench.core.validation.refusals import name as check_name
from workbench.core.validation.signatures import check_arguments
from workbench.handover.c99.c_names import LONGEST, prefix_of
from workbench.handover.export_seal import OPEN_SEAL, seal
from workbench.handover.fmi.binary import compiler_of, library
from workbench.handover.fmi.co_simulation import FIXED, Model, Variable, digest, model_of
from workbench.handover.fmi.description import build_description, model_description
from workbench.handover.fmi.step_sources import compiled_files, sources_of

VERSIONS = ("2.0", "3.0")
EPOCH = (1980, 1, 1, 0, 0, 0)  # the first date that an archive can hold: the same for all files
DESCRIPTION = "modelDescription.xml"
OWN_FILES = "model", "instance", "fmi2", "fmi3"  # which the files of a law must not be called


@dataclass(frozen=True, eq=False)
@check_arguments
class Fmu:
    """A functional mock-up unit for co-simulation; `write` makes the file.

    Attributes
    ----------
    identifier
        The name of its library.
    step
        Of which a communication step must be a whole multiple, s.
    files
        The contents of the archive by their paths.
    without_library
        Why it has sources alone; empty if it has a library for this platform.
    """

    name: str
    version: str
    identifier: str
    token: str
    step: float
    variables: tuple[Variable, ...]
    files: Mapping[str, bytes]
    without_library: str = ""

    @check_arguments
    def content(self) -> bytes:
        """The bytes of the archive, the same for the same files."""
        stream = io.BytesIO()
        with zipfile.ZipFile(stream, "w") as archive:
            for path in sorted(self.files, key=lambda path: (path != DESCRIPTION, path)):
                entry = zipfile.ZipInfo(path, EPOCH)
                entry.create_system = 3
                entry.external_attr = 0o644 << 16
                # as it stands, the description tells without unpacking who has written the file
                packed = zipfile.ZIP_STORED if path == DESCRIPTION else zipfile.ZIP_DEFLATED
                archive.writestr(entry, self.files[path], packed, 9)
            archive.comment = OPEN_SEAL.encode()
        return seal(stream.getvalue())

    @check_arguments
    def write(self, path: str | Path) -> Path:
        """Write the archive to a path that ends with '.fmu', all of it or nothing.

        Raises
        ------
        ValueError
            If the path has another ending, is a folder, a pipe or a device, or cannot be written.
        """
        if "\0" in str(path) or Path(path).suffix != ".fmu" or other_kind(path):
            raise ValueError(
                "`Fmu.write(path)` must be a file that ends with '.fmu', as 'motor.fmu' does; got "
                f"{describe(str(path))}."
            )
        target = Path(path)
        draft = target.with_name(f".{target.name}.{secrets.token_hex(4)}")
        try:
            draft.write_bytes(self.content())
            os.replace(draft, target)
        except OSError as error:
            raise ValueError(
                f"`Fmu.write(path)` cannot write '{path}': {error.strerror or error}. Name a file in a folder that is "
                "there and that you may write."
            ) from error
        finally:
            with suppress(OSError):
                draft.unlink()
        return target

    def __repr__(self) -> str:
        roles = [variable.role for variable in self.variables if variable.role != FIXED]
        numbers = {role: roles.count(role) for role in dict.fromkeys(roles)}
        counts = ", ".join(f"{n} {role}{'' if n == 1 else 's'}" for role, n in numbers.items())
        has = f"sources alone: {self.without_library}" if self.without_library else self._library
        return f"<Fmu '{self.name}', FMI {self.version}: {counts}, steps of {self.step:g} s; {has}>"

    @property
    def _library(self) -> str:
        return ", ".join(path for path in self.files if path.startswith("binaries/"))


@check_arguments
def fmu(
    what: SampledLaw | Ode | SampledSystem,
    version: str = "2.0",
    name: str | None = None,
    *,
    h: float | None = None,
    compiler: str | None = None,
) -> Fmu:
    """The FMU for co-simulation of a law, a plant or a closed loop: sources in C and the library of this platform.

    A law has inputs 'y.q' for its readings and 'r.q' for its references, and outputs 'u.tau' for its commands. After a
    step, the outputs are the commands for the readings that were set before it. Parameters can be changed between
    steps; 'start.q' is a state at the first instant. A communication step is a whole multiple of the FMU's step; inputs
    are held over it.

    Parameters
    ----------
    what
        A law, as of `loop.digital(...).law()`; a plant, as of `open_loop(plant)`; a loop: `loop.digital(...)` or
        `loop.ode()`.
    version
        The version of the FMI standard, "2.0" or "3.0".
    name
        The name of the model; by default that of `what`.
    h
        The step in s for the equations of a plant or a loop; for a loop in a computer it must divide the period.
    compiler
        The name of a C compiler, by default the first of cc, gcc and clang that is found; '' for sources alone.

    Raises
    ------
    ValueError
        If `what` has noise, a name that FMI cannot hold, two variables of one name or a number that is not finite; if h
        is missing or wrong; or if the compiler refuses the sources.
    LookupError
        If there is no such compiler.

    References
    ----------
    Modelica Association, Functional Mock-up Interface, versions 2.0.4 and 3.0.2.

    Examples
    --------
    >>> motor = wb.fmu(wb.open_loop(wb.DCMotor()), "3.0", "motor", h=1e-3, compiler="")
    >>> motor.step, [variable.name for variable in motor.variables if variable.role == "output"]
    (0.001, ['omega'])
    """
    version = one_of("fmu(version=...)", version, VERSIONS)
    call = compiler_of(compiler)
    model = model_of(what, check_name("fmu(name=...)", what.name if name is None else name), h)
    return _assembled(model, version, call)


def _assembled(model: Model, version: str, call: str) -> Fmu:
    """The FMU of a model; its token is that of all that is written in it."""
    identifier = _identifier(model.name)
    unnamed = sources_of(model, identifier, version, "")
    compiled = compiled_files(unnamed)
    description = model_description(model, identifier, version, "", compiled)
    token = digest(model.fingerprint, description.decode(), *unnamed, *unnamed.values())
    token = f"{{{token}}}"
    sources = sources_of(model, identifier, version, token)
    built = library(sources, compiled, identifier, version, call)
    files = {DESCRIPTION: model_description(model, identifier, version, token, compiled)}
    files |= {f"sources/{file}": text.encode() for file, text in sources.items()}
    files |= {built.path: built.content} if built.path else {}
    files |= {"sources/buildDescription.xml": build_description(identifier, compiled)} if version == "3.0" else {}
    fields = (token, model.step.h, model.variables, files, built.reason)
    return Fmu(model.name, version, identifier, *fields)


def _identifier(name: str) -> str:
    """The name of the library: an identifier of C that is like the model's name."""
    letters = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_")
    letters = f"{letters}_fmu" if letters.lower() in OWN_FILES else letters
    return prefix_of((letters if letters[:1].isalpha() else f"fmu_{letters}".strip("_"))[:LONGEST])
