"""`sunset models`: list the segmentation models and show their cards."""

import argparse
import json

from sunset.perception import list_models as shipped_models
from sunset.perception import load_model

__all__ = ["add_parser", "list_models", "show"]


def add_parser(verbs: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb."""
    parser = verbs.add_parser("models", help="list segmentation models, show their cards")
    actions = parser.add_subparsers(title="actions", metavar="ACTION", required=True)
    listing = actions.add_parser("list", help="list the models that come with SUNSET")
    listing.add_argument("--json", action="store_true", help="print one JSON object")
    listing.set_defaults(execute=list_models)
    showing = actions.add_parser("show", help="print a model's card")
    showing.add_argument("model", help="a model's name or folder")
    showing.add_argument("--json", action="store_true", help="print the card as one JSON object")
    showing.set_defaults(execute=show)


def list_models(arguments: argparse.Namespace) -> int:
    """Print the names."""
    if arguments.json:
        print(json.dumps({"models": list(shipped_models())}))
        return 0
    for name in shipped_models():
        print(name)
    return 0


def show(arguments: argparse.Namespace) -> int:
    """Print a card."""
    model = load_model(arguments.model)
    print(json.dumps(model.card.to_json(), sort_keys=True) if arguments.json else model.card.to_text())
    return 0
