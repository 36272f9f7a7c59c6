"use strict";
(() => {
  const all = [...document.querySelectorAll("details")], button = document.getElementById("unfold");
  const reveal = () => {
    const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    const fold = target && target.closest("details");
    if (fold) { fold.open = true; fold.scrollIntoView(); }
  };
  const label = () => { button.textContent = all.every(fold => fold.open) ? "Close all" : "Open all"; };
  const toggle = () => { const open = !all.every(fold => fold.open); for (const fold of all) fold.open = open; };
  let before = [];
  addEventListener("hashchange", reveal);
  addEventListener("beforeprint", () => { before = all.map(fold => fold.open); for (const fold of all) fold.open = true; });
  addEventListener("afterprint", () => all.forEach((fold, i) => { fold.open = before[i]; }));
  for (const fold of all) fold.addEventListener("toggle", label);
  button.addEventListener("click", toggle);
  button.hidden = false;
  label();
  reveal();
})();
