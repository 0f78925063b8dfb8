"""Print the table of all keys of case files in Markdown, for examples/README.md.

python docs/keys.py
"""

from ertel.inputs import layout


def main() -> None:
    print("| section | key | value | meaning | default |\n| --- | --- | --- | --- | --- |")
    for title, text, keys in layout.places():
        print(f"| `{title}` | | | {cell(text)} | |")
        for key in keys:
            default = key.default if key.default in ("", layout.NEEDED) or "(" in key.default else f"`{key.default}`"
            print(f"| | `{key.name}` | {key.kind} | {cell(key.meaning.text)} | {default} |".replace("  ", " "))


def cell(text: str) -> str:
    """A text in a table, where a line between bars would end its cell."""
    return text.replace("|", "\\|")


if __name__ == "__main__":
    main()
