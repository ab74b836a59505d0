"""The table of `realitygap engines`, made without importing an engine that is not installed."""


def engines_table() -> str:
    """Every engine: version, or how to install it, and what it can and cannot express."""
    import realitygap_engines as engines

    lines = []
    for name in sorted(engines.ENGINES):
        entry = engines.ENGINES[name]
        if name not in engines.available():
            lines.append(f"{name}: not installed; install it with: {entry.install}")
            continue
        engine = engines.load(name)
        lines.append(f"{name} {engine.version}")
        lines += [f"  {what:18} {c.level:9} {c.how}" for what, c in sorted(engine.capabilities().items())]
    return "\n".join(lines)
