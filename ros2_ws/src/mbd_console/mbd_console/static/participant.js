// The participant's page: sends forms, keeps what is being filled in, and reads the robot's sentences aloud.
(() => {
  const draft = (form) => `form:${form.dataset.form}`;
  const answersIn = (form) => {
    const answers = {};
    for (const field of form.elements) {
      if (!field.name || ((field.type === "radio" || field.type === "checkbox") && !field.checked)) continue;
      answers[field.name] = field.value;
    }
    return answers;
  };
  // In the page's own language, not in the browser's: what lacks, or once, what is left open.
  const complete = (form) => {
    const note = form.querySelector(".form-note");
    const answers = answersIn(form);
    const marked = (items) => {
      for (const item of form.querySelectorAll(".item")) item.classList.toggle("left-open", items.includes(item));
      const field = items[0]?.querySelector("input, textarea");
      items[0]?.scrollIntoView({ block: "center" });
      field?.focus({ preventScroll: true });
    };
    const items = [...form.querySelectorAll(".item")];
    const fields = (item) => [...item.querySelectorAll("input, textarea")];
    const empty = (item) => !fields(item).some((field) => (answers[field.name] ?? "").trim());
    const badNumber = (field) => field.type === "number" && !field.validity.valid && !field.validity.valueMissing;
    const cases = [
      ["number", items.filter((item) => fields(item).some(badNumber))],
      ["lacks", items.filter((item) => empty(item) && fields(item).some((field) => field.required))],
      ["open", items.filter((item) => empty(item) && item.matches("fieldset"))],
    ];
    const [kind, found] = cases.find((one) => one[1].length) ?? ["", []];
    const again = kind === "open" && note.dataset.told === String(found.length);
    note.dataset.told = kind === "open" ? String(found.length) : "";
    if (!kind || again) return true;
    note.textContent = note.dataset[kind];
    marked(found);
    return false;
  };
  document.addEventListener("submit", (event) => {
    const form = event.target.closest("form.study-form");
    if (!form) return;
    event.preventDefault();
    if (!complete(form)) return;
    emitEvent("form", { form: form.dataset.form, language: form.dataset.language, answers: answersIn(form) });
  });
  document.addEventListener("click", (event) => {
    const form = event.target.closest?.("[data-decline]")?.closest("form.study-form");
    if (form) emitEvent("form", { form: form.dataset.form, language: form.dataset.language, declined: true });
  });
  document.addEventListener("input", (event) => {
    const form = event.target.closest?.("form.study-form");
    if (form) sessionStorage.setItem(draft(form), JSON.stringify(answersIn(form)));
  });
  // "Point at it": who has a tablet in hand points at the picture.
  document.addEventListener("click", (event) => {
    if (!event.target.closest?.(".observer .drawing") || !document.querySelector(".prompt.question")) return;
    const words = document.querySelector(".only-shown-words");
    if (!words) return;
    words.textContent = words.dataset.words;
    setTimeout(() => { words.textContent = ""; }, 6000);
  });
  new MutationObserver(() => {
    const form = document.querySelector("form.study-form:not([data-restored])");
    if (!form) return;
    form.dataset.restored = "1";
    const answers = JSON.parse(sessionStorage.getItem(draft(form)) ?? "{}");
    for (const field of form.elements) {
      if (!field.name || !(field.name in answers)) continue;
      if (field.type === "radio" || field.type === "checkbox") field.checked = field.value === answers[field.name];
      else field.value = answers[field.name];
    }
    const title = form.querySelector("h2");
    title.tabIndex = -1;
    title.focus();
  }).observe(document.documentElement, { childList: true, subtree: true });

  // Speech, where the browser can and the switch is on.
  let said = "";
  setInterval(() => {
    const box = document.getElementById("speak");
    if (!box || !("speechSynthesis" in window)) return;
    if (box.parentElement.hidden) {
      box.parentElement.hidden = false;
      box.checked = localStorage.getItem("speak") === "1";
      box.addEventListener("change", () => {
        localStorage.setItem("speak", box.checked ? "1" : "0");
        said = "";
        if (!box.checked) speechSynthesis.cancel();
      });
    }
    const text = document.querySelector("[data-speak-text]")?.dataset.speakText ?? "";
    if (!box.checked || !text || text === said) return;
    said = text;
    speechSynthesis.cancel();
    const sentence = new SpeechSynthesisUtterance(text);
    sentence.lang = document.documentElement.lang;
    speechSynthesis.speak(sentence);
  }, 300);
})();
