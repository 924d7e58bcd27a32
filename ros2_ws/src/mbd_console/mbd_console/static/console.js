// Sends what is pressed to the server, which decides what it means; keeps the live picture fresh.
(() => {
  const question = () => Number(document.querySelector("[data-question]")?.dataset.question ?? -1);

  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.repeat) return;
    const typing = event.target instanceof HTMLInputElement || event.target instanceof HTMLTextAreaElement;
    if (typing) {
      if (event.key === "Escape") event.target.blur();
      return;
    }
    if (event.key === "t") {
      document.querySelector(".note-input")?.focus();
      event.preventDefault();
    } else if (event.key === "Escape" || /^[a-zA-Z1-9]$/.test(event.key)) {
      emitEvent("console", { action: "key", key: event.key, question: question() });
    }
  });

  document.addEventListener("click", (event) => {
    const target = event.target instanceof Element ? event.target : null;
    const object = target?.closest(".choosing [data-object]");
    const place = target?.closest(".choosing [data-place]");
    const step = target?.closest(".correctable[data-step]");
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
