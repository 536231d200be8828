// Lets drawings move, with a button to stop them; `draw` is called with the seconds that have gone.
function swing(box, draw) {
  const button = box.querySelector("button");
  let moving = false;
  let gone = 0;
  let last = 0;
  const frame = (now) => {
    if (!moving) return;
    gone += Math.min(now - last, 100);
    last = now;
    draw(gone / 1000);
    requestAnimationFrame(frame);
  };
  const set = (on) => {
    moving = on;
    last = performance.now();
    button.textContent = on ? "Hold still" : "Let them move";
    if (on) requestAnimationFrame(frame);
  };
  button.hidden = false;
  button.addEventListener("click", () => set(!moving));
  addEventListener("beforeprint", () => draw((gone = 0)));
  set(!matchMedia("(prefers-reduced-motion: reduce)").matches);
}
