// Pairs of clicks, a corner of the model and its place in the image; the server makes a pose of them.
const token = document.body.dataset.token
const [drawing, photo, said, list, save, wire, marks] =
  ["drawing", "photo", "status", "pairs", "save", "wire", "marks"].map(id => document.getElementById(id))
const model = JSON.parse(document.getElementById("model").textContent)
const pen = drawing.getContext("2d")
const HIT = 24 // px of the drawing: how near to a corner a click must be
const MOVED = 4 // px of the screen: farther is a drag
const whole = photo.viewBox.baseVal
const home = { x: whole.x, y: whole.y, width: whole.width, height: whole.height }
let turn = [[0.8, -0.6, 0], [-0.3, -0.4, -0.87], [0.52, 0.69, -0.5]] // rows: right, down, away
let chosen = null // index of a corner
let pairs = [] // {corner, at: [u, v]}
let asked = 0
let over = false

const turned = point => turn.map(row => row.reduce((sum, value, i) => sum + value * point[i], 0))
const moved = point => turned(point.map((value, i) => value - model.middle[i]))
const place = point => {
  const [x, y, z] = moved(point)
  const scale = 0.9 * drawing.width / model.size
  return [drawing.width / 2 + scale * x, drawing.height / 2 + scale * y, z]
}

function inFront(line) {
  const towards = model.line_faces[line].map(face => face >= 0 && turned(model.normals[face])[2] < 0)
  if (model.smooth[line]) return towards[0] !== towards[1] ? true : null
  return model.line_faces[line].every(face => face < 0) || towards.some(Boolean)
}

function draw() {
  pen.clearRect(0, 0, drawing.width, drawing.height)
  const ink = getComputedStyle(document.body).color
  const at = model.vertices.map(place)
  model.lines.forEach(([a, b], line) => {
    const front = inFront(line)
    if (front === null) return
    pen.globalAlpha = front ? 1 : 0.2
    pen.strokeStyle = ink
    pen.lineWidth = 1.5
    pen.beginPath()
    pen.moveTo(at[a][0], at[a][1])
    pen.lineTo(at[b][0], at[b][1])
    pen.stroke()
  })
  pen.globalAlpha = 1
  model.corners.forEach((corner, i) => {
    const [x, y] = place(corner)
    const number = pairs.findIndex(pair => pair.corner === i)
    pen.fillStyle = i === chosen ? "#d00060" : number >= 0 ? "#e07800" : "#2080c0"
    pen.beginPath()
    pen.arc(x, y, i === chosen ? 9 : 5, 0, 7)
    pen.fill()
    pen.font = "700 22px sans-serif"
    if (number >= 0) pen.fillText(number + 1, x + 9, y - 9)
  })
}

// The nearest to the viewer of the corners that a click may mean.
function cornerAt(x, y) {
  let best = null
  model.corners.forEach((corner, i) => {
    const [u, v, z] = place(corner)
    const off = Math.hypot(u - x, v - y)
    const cost = off + HIT * z / model.size
    if (off < HIT && (best === null || cost < best.cost)) best = { i, cost }
  })
  return best === null ? null : best.i
}

function rotate(dx, dy) {
  const [a, b] = [dx / 150, dy / 150]
  const [right, down, away] = turn
  const mix = (p, q, angle) => [p.map((v, i) => Math.cos(angle) * v - Math.sin(angle) * q[i]),
    p.map((v, i) => Math.sin(angle) * v + Math.cos(angle) * q[i])]
  const [newRight, back] = mix(right, away, a)
  const [newDown, newAway] = mix(down, back, b)
  turn = [newRight, newDown, newAway]
  draw()
}

function listen(element, click, drag) {
  let start = null
  let dragged = false
  element.addEventListener("pointerdown", event => {
    start = [event.clientX, event.clientY]
    dragged = false
    element.setPointerCapture(event.pointerId)
  })
  element.addEventListener("pointermove", event => {
    if (start === null) return
    const [dx, dy] = [event.clientX - start[0], event.clientY - start[1]]
    if (!dragged && Math.hypot(dx, dy) < MOVED) return
    dragged = true
    start = [event.clientX, event.clientY]
    drag(dx, dy)
  })
  element.addEventListener("pointerup", event => {
    if (start !== null && !dragged) click(event)
    start = null
  })
}

listen(drawing, event => {
  const box = drawing.getBoundingClientRect()
  const scale = drawing.width / box.width
  chosen = cornerAt((event.clientX - box.left) * scale, (event.clientY - box.top) * scale)
  said.textContent = chosen === null ? "There is no corner: click a dot."
    : `Corner (${model.corners[chosen].map(value => +value.toPrecision(4)).join(", ")}) m: now its place in the image.`
  draw()
}, rotate)

const inImage = event => {
  const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(photo.getScreenCTM().inverse())
  return [at.x, at.y]
}

listen(photo, event => {
  if (over) return
  if (chosen === null) { said.textContent = "First a corner in the drawing, then its place here."; return }
  pairs = pairs.filter(pair => pair.corner !== chosen).concat({ corner: chosen, at: inImage(event) })
  chosen = null
  changed()
}, (dx, dy) => {
  const scale = photo.getScreenCTM().a
  whole.x -= dx / scale
  whole.y -= dy / scale
})

photo.addEventListener("wheel", event => {
  event.preventDefault()
  const [u, v] = inImage(event)
  const width = Math.min(home.width, whole.width * Math.exp(event.deltaY / 500))
  const factor = width / whole.width
  const held = (at, start, size, least, all) =>
    Math.max(least, Math.min(least + all - size, at - (at - start) * factor))
  whole.x = held(u, whole.x, width, home.x, home.width)
  whole.y = held(v, whole.y, whole.height * factor, home.y, home.height)
  whole.height *= factor
  whole.width = width
  mark([])
}, { passive: false })

let errors = []
function mark(told) {
  if (told.length) errors = told
  const size = whole.width / 100
  marks.innerHTML = pairs.map(({ at: [u, v] }, i) =>
    `<circle cx="${u}" cy="${v}" r="${size / 2}"/>` +
    `<text x="${u + size}" y="${v - size}" font-size="${2 * size}">${i + 1}</text>`).join("")
  list.innerHTML = pairs.map(({ at: [u, v] }, i) => `<li><span>${i + 1}: ${u.toFixed(1)}, ${v.toFixed(1)}` +
    (i < errors.length ? `, off by ${errors[i].toFixed(1)} px` : "") +
    `</span><button data-drop="${i}">remove</button></li>`).join("")
}

list.addEventListener("click", click => {
  if (over || !click.target.dataset.drop) return
  pairs.splice(Number(click.target.dataset.drop), 1)
  changed()
})

async function ask(path) {
  try {
    const body = JSON.stringify(pairs)
    const answer = await fetch(path, { method: "POST", headers: { "X-Token": token }, body })
    return answer.ok ? await answer.json() : { problem: await answer.text() }
  } catch (error) {
    return { problem: "The command does not answer: has it ended?" }
  }
}

async function changed() {
  const number = ++asked
  errors = []
  save.disabled = true
  mark([])
  draw()
  const found = await ask("pose")
  if (number !== asked) return
  wire.innerHTML = (found.lines || []).map(line => `<path d="M${line.join("L")}"/>`).join("")
  if (found.problem) { said.textContent = found.problem; return }
  turn = found.rotation
  save.disabled = false
  said.textContent = found.wrong || `RMS ${found.rms_px.toFixed(2)} px.` + (found.others
    ? ` ${found.others + 1} poses fit these points; this one fits the image best. Another point decides.` : "")
  mark(found.errors_px)
  draw()
}

save.addEventListener("click", async () => {
  const answer = await ask("save")
  over = !answer.problem
  save.disabled = over
  said.textContent = answer.problem || answer.said
})

draw()
