"""Templates: what is filled in is data, and a word that is not given is an error."""

import jinja2
import pytest

from workbench.core import templates
from workbench.core.templates import fill, template_text


@pytest.fixture
def texts(monkeypatch):
    """A function that makes a text the template of a name."""
    held = {}
    monkeypatch.setattr(templates, "template_text", lambda package, path: held[path])
    templates._environment.cache_clear()
    yield held.__setitem__
    templates._environment.cache_clear()


NAME = "{{ 7 * 7 }} {% raw %} ${x} <b> & \"quoted\" 'name' #}"


def test_a_name_that_looks_like_a_template_stands_as_it_is(texts):
    texts("a.c.j2", "/* {{ title }} */\n")
    assert fill("package", "a.c.j2", title=NAME) == f"/* {NAME} */\n"


@pytest.mark.parametrize("language", ["html", "xml"])
def test_a_name_is_escaped_in_a_page_and_in_xml(texts, language):
    texts(f"a.{language}.j2", '<p title="{{ title }}">{{ title }}</p>\n')
    text = fill("package", f"a.{language}.j2", title=NAME)
    assert text.count("<") == text.count(">") == 2
    assert text.count('"') == 2


@pytest.mark.parametrize("template", ["{{ title }}", "{% if title %}a{% endif %}", "{% for x in title %}{% endfor %}"])
def test_a_word_that_is_not_given_is_an_error(texts, template):
    texts("a.c.j2", template)
    with pytest.raises(jinja2.UndefinedError, match="'title' is undefined"):
        fill("package", "a.c.j2", name="law")


def test_a_line_with_a_statement_leaves_no_line_and_the_last_line_ends(texts):
    texts("a.c.j2", "{% for x in xs %}\n    f({{ x }});\n{% endfor %}\nint w[] = {{ xs | initializer }};\n")
    assert fill("package", "a.c.j2", xs=[1, 2.5]) == "    f(1);\n    f(2.5);\nint w[] = {1, 2.5};\n"


def test_the_files_of_a_package_are_found_wherever_it_is_installed():
    assert "platform_start" in template_text("workbench.handover", "targets/platform.h")
    assert "<html" in template_text("workbench.report", "page.html.j2")
