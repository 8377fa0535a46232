"""The directive `scenario-gallery`: a card for each scenario of the library, from its YAML."""

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from scenarios.format.loading import library, load

PICTURES = "scenarios/gallery"  # which `make docs` puts beside the pages


def _card(name: str) -> list[str]:
    _, scenario = load(name)
    truth = scenario.acceptance.truth
    return [
        f":::{{grid-item-card}} {name}",
        f":img-top: {PICTURES}/{name}.png",
        f":img-alt: {name}",
        "",
        f"{scenario.description}.",
        "",
        *([f"*Judged by:* {truth}", ""] if truth else []),
        "```sh",
        f"contact-toolkit run {name}",
        "```",
        ":::",
    ]


class ScenarioGallery(SphinxDirective):
    """Cards with picture, description and command."""

    def run(self) -> list[nodes.Node]:
        """Return the cards."""
        cards = ["::::{grid} 1 2 2 3", ":gutter: 3", ""]
        for name, path in library().items():
            self.env.note_dependency(str(path))
            cards += _card(name)
        return self.parse_text_to_nodes("\n".join([*cards, "::::"]))


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("scenario-gallery", ScenarioGallery)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
