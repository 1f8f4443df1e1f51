"""schema.py SCHEMA_FOLDER [--mutate] DOCUMENT...: every document is what the schema of its format says.

With --mutate, the first document of each format is also spoilt in every way of a list, one at a time
(a member left out, a member unheard of, a value of another kind), and each must be refused; every
schema of the folder must then have had its document.
"""
import copy
import json
import pathlib
import sys
import warnings

try:
    import jsonschema
except ImportError:
    print("schema.py: no module jsonschema; python3-jsonschema is needed")
    sys.exit(77)

# objects whose names are data
OPEN = {("halflight-info", ("features",))}


def spoils(document, node, path=()):
    """Every (what, spoilt copy); of a list, the first element alone."""

    def spoilt(change):
        twin = copy.deepcopy(document)
        at = twin
        for key in path:
            at = at[key]
        change(at)
        return twin

    name = "/".join(map(str, path))
    if isinstance(node, dict):
        if (document["format"], path) not in OPEN:
            yield f"{name}: a member unheard of", spoilt(lambda at: at.update(unheard_of=1))
        for key, value in node.items():
            yield f"{name}/{key}: an object {{}}", spoilt(lambda at, k=key: at.update({k: {"a": {}}}))
            yield from spoils(document, value, path + (key,))
    elif isinstance(node, list) and node:
        yield f"{name}: its first is an object", spoilt(lambda at: at.__setitem__(0, {"a": {}}))
        yield from spoils(document, node[0], path + (0,))


def main():
    folder = pathlib.Path(sys.argv[1]).resolve()
    mutate = "--mutate" in sys.argv
    validators = {}
    warnings.simplefilter("ignore", DeprecationWarning)  # RefResolver: all that Debian 12 has
    for path in sorted(folder.glob("*.schema.json")):
        schema = json.loads(path.read_text())
        jsonschema.Draft202012Validator.check_schema(schema)
        resolver = jsonschema.RefResolver(path.as_uri(), schema)
        validators["halflight-" + path.name.split(".")[0]] = jsonschema.Draft202012Validator(
            schema, resolver=resolver)
    bad = 0
    first = {}
    for name in sys.argv[2:]:
        if name == "--mutate":
            continue
        document = json.loads(pathlib.Path(name).read_text())
        validator = validators.get(document.get("format"))
        if not validator:
            print(f"{name}: format {document.get('format')!r} has no schema")
            bad += 1
            continue
        for error in list(validator.iter_errors(document))[:3]:
            error = next(iter(sorted(error.context, key=lambda e: -len(e.path))), error)
            print(f"{name}: {'/'.join(map(str, error.absolute_path))}: {error.message[:200]}")
            bad += 1
        first.setdefault(document["format"], document)
    if not mutate:
        print(f"{len(sys.argv) - 2} documents, {bad} faults")
        return bad
    refused = 0
    for form, document in first.items():
        required = [k for k in document if k in validators[form].schema.get("required", ())]
        tries = [(f"without {k}", {i: v for i, v in document.items() if i != k}) for k in required]
        for what, spoilt in tries + list(spoils(document, document)):
            if validators[form].is_valid(spoilt):
                print(f"{form}: accepted, though spoilt: {what}")
                bad += 1
            refused += 1
    for form in sorted(set(validators) - set(first)):
        print(f"{form}: no document was validated")
        bad += 1
    print(f"{len(sys.argv) - 3} documents of {len(first)} formats, {refused} spoilt ones, {bad} faults")
    return bad


sys.exit(1 if main() else 0)
