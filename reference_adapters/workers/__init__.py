"""Engines in separate interpreters, because of conflicting requirements or licences."""
