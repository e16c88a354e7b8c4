// Puts the parts that the server sends into the page, and carries what is pressed back.
const token = document.body.dataset.token
const link = document.getElementById("link")
const events = new EventSource("events?token=" + encodeURIComponent(token))
let over = false
events.onopen = () => { link.textContent = "" }
events.onmessage = message => {
  for (const [name, html] of Object.entries(JSON.parse(message.data))) {
    document.getElementById(name).innerHTML = html
  }
}
events.addEventListener("end", () => {
  over = true
  events.close()
  link.textContent = "The view has ended; this is what it showed last."
})
events.onerror = () => { if (!over) link.textContent = "The view does not answer; trying again …" }
document.addEventListener("click", async click => {
  const word = click.target.dataset && click.target.dataset.word
  if (!word) return
  try {
    const answer = await fetch("control", { method: "POST", headers: { "X-Token": token }, body: word })
    link.textContent = answer.ok ? "" : await answer.text()
  } catch (error) {
    link.textContent = "The view does not answer."
  }
})
