// The room's bytes, from where the page came from.
export async function fetchRoom() {
  const response = await fetch('./room.glb');
  if (!response.ok) throw new Error(`room.glb: ${response.status} ${response.statusText}`);
  return response.arrayBuffer();
}
