// The picture of a scene in a notebook. A drag turns it, the wheel zooms. The kernel makes every picture; one
// request is under way at a time, and what happens meanwhile becomes the next one.
function render({ model, el }) {
  const picture = document.createElement("img");
  const note = document.createElement("div");
  const [width, height] = model.get("size");
  Object.assign(picture.style, { width: `${width}px`, height: `${height}px`, cursor: "grab", touchAction: "none" });
  picture.draggable = false;
  picture.alt = "a scene; drag to turn it, turn the wheel to zoom";
  note.style.font = "12px sans-serif";
  el.append(picture, note);

  let url = null;
  let isBusy = false;
  const wanted = [];
  const next = () => {
    if (isBusy || wanted.length === 0) return;
    isBusy = true;
    model.send(wanted.shift());
  };
  const request = (message) => {
    const last = wanted[wanted.length - 1];
    if (last && last.kind === message.kind && last.drag === message.drag) {
      if (message.kind === "zoom") message.factor *= last.factor;
      wanted.pop();
    }
    wanted.push(message);
    next();
  };
  const show = () => {
    if (url) URL.revokeObjectURL(url);
    url = URL.createObjectURL(new Blob([model.get("png")], { type: "image/png" }));
    picture.src = url;
    note.textContent = model.get("note");
  };
  const answered = () => {
    isBusy = false;
    show();
    next();
  };

  // Radii of the ball: the middle of the picture is 0 0, and y goes up.
  const onBall = (event) => {
    const box = picture.getBoundingClientRect();
    const radius = Math.min(box.width, box.height) / 2;
    return [
      (event.clientX - box.left - box.width / 2) / radius,
      (box.top + box.height / 2 - event.clientY) / radius,
    ];
  };
  let drag = 0;
  let from = null;
  let sharpen = null;
  const turn = (event, isLast) => {
    if (!from) return;
    request({ kind: "turn", drag, from, to: onBall(event), last: isLast });
    if (isLast) from = null;
  };
  picture.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    picture.setPointerCapture(event.pointerId);
    drag += 1;
    from = onBall(event);
    event.preventDefault();
  });
  picture.addEventListener("pointermove", (event) => turn(event, false));
  picture.addEventListener("pointerup", (event) => turn(event, true));
  picture.addEventListener("pointercancel", (event) => turn(event, true));
  picture.addEventListener("wheel", (event) => {
    event.preventDefault();
    request({ kind: "zoom", drag: 0, factor: Math.exp(Math.sign(event.deltaY) * 0.1) });
    clearTimeout(sharpen);
    sharpen = setTimeout(() => request({ kind: "sharpen", drag: 0 }), 200);
  }, { passive: false });

  model.on("change:count", answered);
  show();
  return () => {
    model.off("change:count", answered);
    clearTimeout(sharpen);
    if (url) URL.revokeObjectURL(url);
  };
}

export default { render };
