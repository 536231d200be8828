/** Tones, so that the operator need not look. High: strike; rising: good; falling: rejected; three short: too early. */

const TONES = {
  ready: [[880, 0.35]],
  good: [[660, 0.1], [990, 0.15]],
  rejected: [[330, 0.25], [220, 0.35]],
  early: [[440, 0.08], [0, 0.05], [440, 0.08], [0, 0.05], [440, 0.08]],
};
const KEPT = "modallab.sound";
let context = null;

export const sound = {
  get on() { return localStorage.getItem(KEPT) !== "off"; },
  set on(value) { localStorage.setItem(KEPT, value ? "on" : "off"); },
};

/** Play the tone of a phase, if it has one. */
export function play(phase) {
  // Browsers let a page sound only after somebody has clicked into it.
  if (!sound.on || !TONES[phase] || navigator.userActivation?.hasBeenActive === false) return;
  context ??= new AudioContext();
  let at = context.currentTime + 0.01;
  for (const [hz, seconds] of TONES[phase]) {
    if (hz) {
      const tone = new OscillatorNode(context, { frequency: hz });
      const level = new GainNode(context, { gain: 0.15 });
      tone.connect(level).connect(context.destination);
      tone.start(at);
      tone.stop(at + seconds);
    }
    at += seconds;
  }
}
