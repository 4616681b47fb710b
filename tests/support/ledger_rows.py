"""The rows of a printed ledger."""

import re
from html.parser import HTMLParser


class Rows(HTMLParser):
    """The rows of the ledger's tables as a browser shows them: [claim, verdict, evidence, witness], all plain text."""

    def __init__(self, page: str) -> None:
        HTMLParser.__init__(self)
        self.rows, self.cells, self.within = [], [], ""
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        if tag == "tr":
            self.cells = []
        if tag in ("td", "th"):
            self.cells.append({"all": "", "strong": "", "code": ""})
        self.within = tag if tag in ("strong", "code") else self.within

    def handle_endtag(self, tag):
        if tag == "tr" and len(self.cells) == 4 and self.cells[0]["strong"]:  # the row of heads has no claim
            claim, _, verdict, evidence = self.cells
            self.rows.append([claim["strong"], verdict["all"].strip(), evidence["all"], evidence["code"]])
        self.within = "" if tag == self.within else self.within

    def handle_data(self, data):
        if self.cells:
            self.cells[-1]["all"] += data
            if self.within:
                self.cells[-1][self.within] += data


def is_printed(number, evidence):
    """Whether a number stands in a text, rounded to the digits that stand there."""
    text = evidence.replace("\N{MINUS SIGN}", "-").replace(",", "")
    for token in re.findall(r"\d+(?:\.\d+)?(?:e-?\d+)?", text):
        mantissa, _, power = token.partition("e")
        unit = 10.0 ** (int(power or 0) - len(mantissa.partition(".")[2]))
        if abs(abs(number) - float(token)) <= 0.501 * unit and float(token) > 0:
            return True
    return False
