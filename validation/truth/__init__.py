"""Reference results: closed forms, certified results, integrations, or Ghostball's engine."""
