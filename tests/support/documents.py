"""Documents with one block of each kind, and words that a page must escape."""

import numpy as np

from workbench.core.notation.formula import Matrix, Relation, symbol
from workbench.study.document.document import (
    Band,
    BoldCell,
    Code,
    Colophon,
    CrossReference,
    DivergedCell,
    Document,
    Equation,
    Figure,
    Itemize,
    Panel,
    Paragraph,
    ReportTable,
    Section,
    Series,
    Strong,
    TableColumn,
    ValueWithError,
    Verdict,
)

HOSTILE = '<script>alert(1)</script><img src=x onerror=alert(2)> "\' & #eval("1") $x$ *b* _i_ @mass \\ `c` // [d] <lab>'


def document(title="Six laws on one arm", *more, words="text"):
    t = np.linspace(0, 1, 50)
    q = symbol("q_1")
    panel = Panel((q, " [rad]"), (Series(words, t, t), Band("band", t, t, t + 1, 1)), title=words)
    blocks = (
        Paragraph((words, q, Code(words), Strong(words), " see ", CrossReference("rmse"), CrossReference("mass"))),
        Equation(Relation(symbol("M"), "=", Matrix(((q, q), (q, q)))), "mass", note=words),
        ReportTable(
            "rmse",
            (words, q),
            (TableColumn(words), TableColumn((q, " ours"), "rad/s^2")),
            (("PID", ValueWithError(0.5847, 0.0002)), (words, BoldCell(DivergedCell(3.14159))), ("SMC", None)),
            (words,),
        ),
        Figure("errors", (words, q, CrossReference("rmse")), (panel,)),
        Verdict("fails", (words, q), words),
        Verdict("holds", words),
        Verdict("open", words),
        Itemize((words, q)),
        *more,
    )
    return Document(
        title=title,
        question=(words, q),
        method=words,
        sections=(Section((words, q, CrossReference("rmse")), blocks),),
        colophon=Colophon(words, "0.1.0", {words: "3f9a2c1b"}, 7, {"casadi": "3.8"}, "3.11"),
    )
