"use strict";
globalThis.Ghostball ??= {};
