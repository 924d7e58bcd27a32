// Sound and picture of the room: from this browser's camera and microphone to the console, a chunk a second.
(() => {
  const CHUNK = 1000, ROUNDS = 8, LOOK_EVERY = 10000, RETRIES = 30, LONGEST_QUEUE = 120;
  const KINDS = ["video/webm;codecs=vp8,opus", "video/webm;codecs=vp9,opus", "video/webm"];
  let film = null;  // what is recorded now
  let busy = false;

  const part = (id) => document.getElementById(id);
  const words = (name, values = {}) => {
    let text = JSON.parse(part("room").dataset.words)[name] ?? name;
    for (const [key, value] of Object.entries(values)) text = text.replace(`{${key}}`, value);
    return text;
  };
  const say = (text) => { part("room-said").textContent = text; };
  const seconds = () => performance.now() / 1000;
  const pause = (ms) => new Promise((done) => setTimeout(done, ms));

  class Refused extends Error {}
  async function ask(address, options = {}) {
    const language = part("room").dataset.language;
    const answer = await fetch(`/room/${address}?lang=${language}`, { cache: "no-store", ...options });
    const read = await answer.json().catch(() => ({}));
    if (!answer.ok) throw new Refused(read.why ?? `${answer.status}`);
    return read;
  }
  const asJson = (value) => (
    { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(value) }
  );

  // Both clocks at one moment: of several round trips the shortest, known to half its length.
  async function look(rounds = ROUNDS) {
    let best = null;
    for (let k = 0; k < rounds; k += 1) {
      const sent = seconds();
      const { session } = await ask("clock");
      const came = seconds();
      if (!best || came - sent < 2 * best[2]) best = [(sent + came) / 2, session, (came - sent) / 2];
    }
    return best;
  }

  function chirp(context, rising) {
    const { low, high, seconds: long, edge } = JSON.parse(part("room").dataset.signal);
    const rate = context.sampleRate;
    const buffer = context.createBuffer(1, Math.round(long * rate), rate);
    const samples = buffer.getChannelData(0);
    const [first, last] = rising ? [low, high] : [high, low];
    for (let k = 0; k < samples.length; k += 1) {
      const t = k / rate;
      const swell = Math.max(0, Math.min(1, Math.min(t, long - t) / edge));
      samples[k] = swell * Math.sin(2 * Math.PI * (first * t + ((last - first) * t * t) / (2 * long)));
    }
    return buffer;
  }

  function play(context, buffer, loudness, to, at) {
    const source = new AudioBufferSourceNode(context, { buffer });
    source.connect(new GainNode(context, { gain: loudness })).connect(to);
    source.start(at);
  }

  // The sound's clock is stepped by its buffers: what is seen right after a step is the least behind.
  async function behind(context, long) {
    let least = Infinity;
    for (const end = seconds() + long; seconds() < end; await pause(1)) {
      least = Math.min(least, seconds() - context.currentTime);
    }
    return least;
  }

  function flash() {
    part("room-flash").hidden = matchMedia("(prefers-reduced-motion: reduce)").matches;
    setTimeout(() => { part("room-flash").hidden = true; }, 200);
  }

  async function signal() {
    const made = film;
    if (!made || made.signalling) return;
    made.signalling = true;
    part("room-signal").disabled = true;
    try {
      made.clock.push(await look());
      const at = made.context.currentTime + 0.5;
      const { after } = JSON.parse(part("room").dataset.signal);
      play(made.context, chirp(made.context, true), 0.25, made.mixed, at);
      play(made.context, chirp(made.context, false), 0.8, made.context.destination, at + after);
      const soon = at + (await behind(made.context, 0.1));
      setTimeout(flash, (soon - seconds()) * 1000);
      // Looked at while it sounds: on a busy machine the sound's clock stops now and then.
      await pause((soon - 0.15 - seconds()) * 1000);
      const begins = at + (await behind(made.context, 0.3));
      await pause(after * 1000);
      const latency = made.context.outputLatency || made.context.baseLatency || 0;
      made.signals.push([made.signals.length + 1, begins, latency]);
      await facts(made);
      say(words("room_signalled", { number: made.signals.length }));
    } finally {
      made.signalling = false;
      part("room-signal").disabled = film !== made;
    }
  }

  const factsOf = (made, ended) => ({
    key: made.key, started: made.started, clock: made.clock, signals: made.signals, ended,
  });
  const facts = (made, ended = false) => ask(made.name, asJson(factsOf(made, ended)));

  async function upload(made) {
    if (made.uploading) return;
    made.uploading = true;
    for (let tries = 0; made.queue.length; ) {
      try {
        await ask(`${made.name}/${made.chunk}`, {
          method: "POST",
          headers: { "Content-Type": "video/webm", "X-Room-Key": made.key },
          body: made.queue[0],
        });
        made.queue.shift();
        made.chunk += 1;
        tries = 0;
      } catch (problem) {
        tries += 1;
        // What was refused is not sent again; a console that is gone may come back.
        if (problem instanceof Refused || tries > RETRIES || made.queue.length > LONGEST_QUEUE) {
          made.queue = [];
          release(made);
          say(problem instanceof Refused ? problem.message : words("room_gone"));
        } else {
          await pause(1000);
        }
      }
    }
    made.uploading = false;
  }

  // With the microphone as it is: what cancels echoes and noise would take the test signal for one.
  async function devices() {
    const audio = { echoCancellation: false, noiseSuppression: false, autoGainControl: false };
    const video = { width: { ideal: 1280 }, height: { ideal: 720 }, frameRate: { ideal: 25, max: 30 } };
    let why = "";
    for (const wanted of [{ audio, video }, { audio }, { video }]) {
      try {
        return await navigator.mediaDevices.getUserMedia(wanted);
      } catch (problem) {
        why = problem.message;
      }
    }
    throw new Refused(words("room_no_device", { why }));
  }

  function release(made) {
    if (film === made) film = null;
    clearInterval(made.looking);
    if (made.recorder.state !== "inactive") made.recorder.stop();
    for (const track of made.stream.getTracks()) track.stop();
    made.context.close().catch(() => {});
    show();
  }

  function show() {
    part("room-switch").setAttribute("aria-checked", String(film !== null));
    part("room-signal").disabled = film === null;
    const picture = part("room-picture");
    picture.hidden = !film?.stream.getVideoTracks().length;
    if (picture.srcObject !== (film?.stream ?? null)) {
      picture.srcObject = film?.stream ?? null;
      picture.muted = true;
      if (film) picture.play().catch(() => {});
    }
  }

  async function begin() {
    if (!navigator.mediaDevices?.getUserMedia) throw new Refused(words("room_insecure"));
    const kind = KINDS.find((name) => window.MediaRecorder?.isTypeSupported(name));
    if (!kind) throw new Refused(words("room_no_webm"));
    await ask("possible");
    say(words("room_opening"));
    const stream = await devices();
    const context = new AudioContext({ latencyHint: "interactive" });
    const made = { stream, context, clock: [], signals: [], queue: [], chunk: 0, started: 0 };
    try {
      await context.resume();
      made.mixed = context.createMediaStreamDestination();
      if (stream.getAudioTracks().length) context.createMediaStreamSource(stream).connect(made.mixed);
      made.clock.push(await look());
      Object.assign(made, await ask("begin", asJson({
        sound: stream.getAudioTracks().length > 0, picture: stream.getVideoTracks().length > 0,
      })));
      made.recorder = new MediaRecorder(
        new MediaStream([...stream.getVideoTracks(), ...made.mixed.stream.getAudioTracks()]),
        { mimeType: kind, videoBitsPerSecond: 2500000, audioBitsPerSecond: 128000 },
      );
    } catch (problem) {
      for (const track of stream.getTracks()) track.stop();
      context.close().catch(() => {});
      throw problem;
    }
    const started = new Promise((done) => { made.recorder.onstart = done; });
    made.recorder.ondataavailable = (event) => {
      if (!event.data.size) return;
      made.queue.push(event.data);
      upload(made);
    };
    for (const track of stream.getTracks()) track.onended = () => film === made && end(words("room_lost"));
    made.started = seconds();
    made.recorder.start(CHUNK);
    await started;
    film = made;
    made.looking = setInterval(async () => {
      try {
        made.clock.push(await look());
        await facts(made);
      } catch { /* the console is gone: the chunks say so */ }
    }, LOOK_EVERY);
    await facts(made);
    show();
    const lacks = [];
    if (!stream.getAudioTracks().length) lacks.push(words("room_picture_only"));
    if (!stream.getVideoTracks().length) lacks.push(words("room_sound_only"));
    say([words("room_runs", { name: made.name }), ...lacks].join(" "));
    await pause(700);
    await signal();
  }

  async function end(why = "") {
    const made = film;
    await signal().catch(() => {});
    await pause(300);
    const stopped = new Promise((done) => { made.recorder.onstop = done; });
    release(made);
    await stopped;
    while (made.queue.length) await pause(50);
    await facts(made, true);
    say(`${why} ${words("room_kept", { name: made.name })}`.trim());
  }

  document.addEventListener("click", async (event) => {
    const pressed = event.target.closest?.("#room-switch, #room-signal");
    if (!pressed || busy) return;
    busy = true;
    try {
      if (pressed.id === "room-signal") await signal();
      else if (film) await end();
      else await begin();
    } catch (problem) {
      say(problem instanceof Refused ? problem.message : `${words("room_gone")} (${problem.message})`);
      if (film) release(film);
    } finally {
      busy = false;
      show();
    }
  });

  // A page that is closed says so; what it had sent stays.
  window.addEventListener("pagehide", () => {
    if (!film) return;
    const last = new Blob([JSON.stringify(factsOf(film, true))], { type: "application/json" });
    navigator.sendBeacon(`/room/${film.name}`, last);
  });
})();
