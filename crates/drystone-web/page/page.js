// The page around the viewer: the address selects the scene, and files can be dropped on it. In
// player.html files are films, and their animations are played.

import init, * as drystone from "./drystone.js";

// The scene if the address has none.
const FIRST = "pyramid:base=12";
// A larger file would fill the page's memory.
const MOST_BYTES = 64 * 1024 * 1024;

document.body.insertAdjacentHTML(
  "afterbegin",
  `<canvas id="canvas" tabindex="0"></canvas>
  <label id="file" hidden>open a file<input type="file" accept=".glb,.gltf,.obj"></label>
  <div id="note">loading …</div>`,
);
const note = document.getElementById("note");
const label = document.getElementById("file");
const address = new URLSearchParams(location.search);
const isPlayer = document.body.dataset.player !== undefined;
const playing = !address.has("paused");
const panel = isPlayer || address.has("bare") ? false : undefined;
let started = false;

function say(text, className = "") {
  note.textContent = String(text);
  note.className = className;
  note.hidden = text === "";
}

const fail = (why) => say(why, "failed");

function start(scene) {
  const why = drystone.start(document.getElementById("canvas"), scene, playing, panel, fail);
  if (why) return why;
  started = true;
  document.getElementById("canvas").focus();
  if (note.className !== "failed") say("");
}

function refuse(name, why) {
  if (started) drystone.drystone_refuse_file(name, why);
  else fail(`${name}: ${why}`);
}

// Opens a file of `size` bytes, as far as known; `read` returns them as a buffer.
async function open(name, size, read) {
  try {
    if (!(size <= MOST_BYTES)) {
      refuse(name, `has ${Math.ceil(size / 1048576)} MB, the maximum is ${MOST_BYTES >> 20} MB`);
      return;
    }
    drystone.drystone_open_file(name, new Uint8Array(await read()), isPlayer);
  } catch (e) {
    refuse(name, `cannot be read: ${e.message}`);
    return;
  }
  if (!started) {
    const why = start(name);
    if (why) fail(why);
  }
}

const openFile = (file) => open(file.name, file.size, () => file.arrayBuffer());

async function openAddress(url) {
  const name = url.split(/[?#]/)[0].split("/").pop() || url;
  say(`loading ${name} …`);
  let answer;
  try {
    answer = await fetch(url);
  } catch (e) {
    return fail(`${url}: ${e.message}`);
  }
  if (!answer.ok) return fail(`${url}: ${answer.status} ${answer.statusText}`);
  await open(name, Number(answer.headers.get("Content-Length") ?? 0), () => answer.arrayBuffer());
}

// When the page is out of memory, the viewer ends without a message of its own.
for (const kind of ["error", "unhandledrejection"]) {
  addEventListener(kind, (event) => {
    const why = event.error ?? event.reason;
    if (why instanceof WebAssembly.RuntimeError && note.className !== "failed") {
      fail(`The viewer has stopped (${why.message}), perhaps for want of memory. Reload the page to go on.`);
    }
  });
}

addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", (event) => {
  event.preventDefault();
  const file = event.dataTransfer.files[0];
  if (file) openFile(file);
});
label.firstElementChild.addEventListener("change", (event) => {
  const file = event.target.files[0];
  event.target.value = "";
  if (file) openFile(file);
});

try {
  await init();
  // For pages that embed this one, and for its test.
  Object.assign(globalThis, drystone);
  label.hidden = address.has("bare");
  const film = address.get("film");
  if (isPlayer && film) {
    await openAddress(film);
  } else if (isPlayer) {
    say("drop a .glb file with animations here");
  } else {
    const scene = address.get("scene") || FIRST;
    if (start(scene) !== undefined) {
      // Shows a scene, with the message in the panel.
      start(FIRST);
      drystone.drystone_open(scene);
    }
  }
} catch (e) {
  fail(`The viewer cannot start: ${e.message ?? e}`);
}
