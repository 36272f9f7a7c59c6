
/* ---- controls: what is set here is sent, and follows what the session has ---- */
const HELD = 1000;           // a control that was just moved is left alone for so long [ms]
let socket = null;
function send(what, values = {}) { if (socket?.readyState === 1) socket.send(JSON.stringify({ do: what, ...values })); }
const valueOf = (c) => (c.type === "range" || "number" in c.dataset ? +c.value : c.value);
function say(c) { if (c.type === "range") c.previousElementSibling.value = signed(+c.value, Math.max(0, Math.ceil(-Math.log10(c.step) - 1e-9))) + c.dataset.unit; }
function follow(c, value) {  // the session's value, unless somebody moves it now
  if (performance.now() - (c.held || -HELD) < HELD) return;
  if (String(c.value) !== String(value)) { c.value = value; say(c); }
}
function onSet(c, act) { c.addEventListener("input", () => { c.held = performance.now(); say(c); act(valueOf(c)); }); say(c); }
function setUpToggles() {    // one panel at a time: the person stays in sight
  for (const b of document.querySelectorAll("#toggles button")) b.addEventListener("click", () => {
    const on = !document.body.classList.contains(b.dataset.panel);
    for (const other of document.querySelectorAll("#toggles button")) {
      const open = on && other === b;
      state.dirty = true; document.body.classList.toggle(other.dataset.panel, open); other.classList.toggle("on", open); other.setAttribute("aria-expanded", open);
    }
  });
}
function connect(receive) {
  socket = new WebSocket(`ws://${location.host}/live`);
  socket.addEventListener("open", () => send("join"));
  socket.addEventListener("message", (ev) => receive(JSON.parse(ev.data)));
  socket.addEventListener("close", () => { $("status").textContent = "The session has ended, or the connection is lost. Reload the page to try again."; });
}
