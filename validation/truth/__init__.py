"""Reference results of scenes: closed forms, certified results, or Ghostball's own engine."""
