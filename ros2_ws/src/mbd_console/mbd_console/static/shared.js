// Both pages: a veil while the console is gone, and what a person was about to write or had in focus kept.
(() => {
  let was = false;  // connected before
  let lost = false;

  const connected = () => Boolean(window.socket?.connected && window.did_handshake);
  function announce() {
    const back = document.getElementById("back");
    if (!back) return setTimeout(announce, 100);
    back.textContent = back.dataset.words;
    setTimeout(() => { back.textContent = ""; }, 6000);
  }
  // A console that was started again has the page loaded again: the word for it outlives the page.
  if (sessionStorage.getItem("lost")) {
    sessionStorage.removeItem("lost");
    announce();
  }
  setInterval(() => {
    const veil = document.getElementById("veil");
    if (connected()) {
      if (lost) {
        sessionStorage.removeItem("lost");
        announce();
      }
      was = true;
      lost = false;
    } else if (was && !lost) {
      lost = true;
      sessionStorage.setItem("lost", "1");
    }
    if (veil && veil.hidden === lost) veil.hidden = !lost;
    document.body.classList.toggle("lost", lost);
  }, 250);
  // Nothing pressed would arrive; what is typed stays.
  document.addEventListener("keydown", (event) => {
    const typing = event.target instanceof HTMLInputElement || event.target instanceof HTMLTextAreaElement;
    if (lost && !(typing && event.key !== "Enter")) {
      event.preventDefault();
      event.stopImmediatePropagation();
    }
  }, true);

  // Fields with a name to keep them under: what is in them outlives a page that is loaded again.
  const kept = (field) => field.closest?.("[data-keep]")?.dataset.keep;
  document.addEventListener("input", (event) => {
    const name = kept(event.target);
    if (name && "value" in event.target && event.isTrusted) sessionStorage.setItem(`keep:${name}`, event.target.value);
  });
  window.forgetKept = (name) => sessionStorage.removeItem(`keep:${name}`);
  function restoreKept() {
    for (const place of document.querySelectorAll("[data-keep]:not([data-restored])")) {
      const field = place.matches("input, textarea") ? place : place.querySelector("input, textarea");
      if (!field || !connected()) continue;
      place.dataset.restored = "1";
      const text = sessionStorage.getItem(`keep:${place.dataset.keep}`);
      if (text) {
        field.value = text;
        field.dispatchEvent(new Event("input", { bubbles: true }));
        field.focus();
      }
    }
  }
  setInterval(restoreKept, 200);

  // Panels are drawn again while somebody works by keyboard: the focus goes back to what it was on.
  let focused = "";
  const quoted = (text) => CSS.escape(text);
  function place(element) {
    if (element.dataset.object) return `.choosing [data-object="${quoted(element.dataset.object)}"]`;
    const step = element.closest(".step[data-step]");
    if (step) return `.step[data-step="${quoted(step.dataset.step)}"] [role=button]`;
    if (element.dataset.study) {
      return `[data-study="${quoted(element.dataset.study)}"][data-name="${quoted(element.dataset.name ?? "")}"]`;
    }
    return "";
  }
  document.addEventListener("focusin", (event) => { focused = place(event.target); });
  document.addEventListener("pointerdown", () => { focused = ""; }, true);
  new MutationObserver(() => {
    if (focused && document.activeElement === document.body) {
      document.querySelector(focused)?.focus({ preventScroll: true });
    }
  }).observe(document.documentElement, { childList: true, subtree: true });
})();
