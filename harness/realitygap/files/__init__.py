"""Files, whatever is in them: YAML that is checked, results that are written whole, errors told in a sentence."""
