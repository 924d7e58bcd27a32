// Sends what is pressed to the server, which decides what it means; keeps the live picture fresh.
(() => {
  const question = () => Number(document.querySelector("[data-question]")?.dataset.question ?? -1);

  const dialog = () => document.getElementById("keys");
  const openKeys = () => { if (!dialog().open) dialog().showModal(); };

  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.repeat || dialog()?.open) return;
    const field = event.target;
    const typing = field instanceof HTMLTextAreaElement || (field instanceof HTMLInputElement && field.type !== "checkbox");
    if (typing) {
      if (event.key === "Escape") field.blur();
      if (event.key === "Enter" && field.classList.contains("note-input")) forgetKept("note");
      return;
    }
    const pressed = field.closest?.('[role="button"]');
    if (pressed && (event.key === "Enter" || event.key === " ")) {
      event.preventDefault();
      pressed.dispatchEvent(new MouseEvent("click", { bubbles: true }));
      return;
    }
    // By Shift, not by the letter that comes: Caps Lock is no other key.
    const letter = /^[a-z]$/i.test(event.key);
    const key = !letter ? event.key : event.shiftKey ? event.key.toUpperCase() : event.key.toLowerCase();
    if (key === "?") openKeys();
    else if (key === "v") document.querySelector("[data-toggle=study]")?.click();
    else if (key === "t") {
      document.querySelector(".note-input")?.focus();
      event.preventDefault();
    } else if (key === "Escape" || letter || /^[1-9]$/.test(key)) {
      emitEvent("console", { action: "key", key, question: question() });
    }
  });

  document.addEventListener("change", (event) => {
    const box = event.target.closest?.("[data-study=tick]");
    if (box) emitEvent("study", { do: "tick", name: box.dataset.name });
  });

  document.addEventListener("click", (event) => {
    const target = event.target instanceof Element ? event.target : null;
    const object = target?.closest(".choosing [data-object]");
    const place = target?.closest(".choosing [data-place]");
    const step = target?.closest(".correctable[data-step]");
    const study = target?.closest("button[data-study]");
    const toggle = target?.closest("[data-toggle]");
    if (study) emitEvent("study", { do: study.dataset.study, name: study.dataset.name });
    if (toggle?.dataset.toggle === "keys") dialog().open ? dialog().close() : openKeys();
    if (toggle?.dataset.toggle === "study") {
      const tools = document.querySelector(".study-tools");
      tools.hidden = !tools.hidden;
      for (const button of document.querySelectorAll("[data-toggle=study]")) button.ariaExpanded = String(!tools.hidden);
      // Not on the first button: it takes a form away from who fills it in, and Space follows easily.
      if (!tools.hidden) tools.focus();
    }
    if (object) {
      emitEvent("console", { action: "object", object_id: object.dataset.object, question: question() });
    } else if (place) {
      const svg = place.ownerSVGElement;
      const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      emitEvent("console", { action: "place", u: at.x, v: at.y, question: question() });
    } else if (step) {
      emitEvent("console", { action: "meant", step: Number(step.dataset.step) });
    }
  });

  // One picture at a time: a slow network gets fewer, never a queue of old ones.
  let version = 0;
  let shown = "";
  async function watch() {
    const image = document.getElementById("live");
    let pause = 200;
    if (image && !document.hidden) {
      try {
        const answer = await fetch(`/picture/live?v=${version}`);
        if (answer.status === 200) {
          version = Number(answer.headers.get("X-Version"));
          const address = URL.createObjectURL(await answer.blob());
          image.src = address;
          await image.decode().catch(() => {});
          if (shown) URL.revokeObjectURL(shown);
          shown = address;
          image.parentElement.classList.add("seen");
        }
      } catch {
        version = 0;  // the console is gone; when it comes back it counts again
        pause = 1000;
      }
    }
    setTimeout(watch, pause);
  }
  watch();
})();
