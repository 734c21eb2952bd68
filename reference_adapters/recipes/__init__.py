"""The best settings that were found for an engine, as code of that engine: no ghostball in it.

Each is a program that plays one cut shot; `ghostball engines NAME --recipe` prints it.
"""
