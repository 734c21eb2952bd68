"""Engines in JavaScript, played by node: planck.js, matter.js and cannon-es.

`driver/` holds what node runs: `serve.mjs` answers, `play.mjs` plays a scene, and each engine is a
short file. `make peers-js` installs the engines by the lock file that lies there.
"""
